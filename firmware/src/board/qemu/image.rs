//! The image for `netduinoplus2`: one session with the PC over the emulator's standard input and output.

use super::{Begin, Exchange, HostGone, SysTick, exit};
use crate::chip::stack::HighWater;
use crate::session::{PeriodReply, SessionAccount};
use crate::station::{FromWatch, Judged, OrdersQueue, WatchParts, Watchers, Watches, pass_on};
use crate::step_time::StepTime;
use cortex_m::Peripherals;
use link::reply::{RefusedParameter, Reply};
use link::{Command, MAX_ACTUATORS};
use outerloop_core::watch::{Seen, steps_in_block};
use outerloop_core::{Design, GroundMotion, OuterLoop, Record};

/// The longest ground motion that fits in the emulated machine's memory.
pub const MAX_POINTS: usize = 14_000;

/// Runs one session to its end; `memory` is for the ground motion.
pub fn main(memory: &mut [f32]) -> ! {
    exit(match session(memory) {
        Ok(()) => 0,
        Err(HostGone) => 1,
    })
}

fn session(memory: &mut [f32]) -> Result<(), HostGone> {
    let mut pc = Exchange::open()?;
    let begin = pc.begin(memory)?;
    let points = memory.get(..begin.points).ok_or(HostGone)?;
    match begin.config.structure.mass_kg.len() {
        1 => run::<1>(&mut pc, &begin, points),
        2 => run::<2>(&mut pc, &begin, points),
        3 => run::<3>(&mut pc, &begin, points),
        n => {
            let refused = RefusedParameter::new("structure.mass_kg", n as f64, "1 to 3 storeys");
            pc.reply(begin.request, Reply::Refused(refused))
        }
    }
}

/// The session of a loop with `N` degrees of freedom.
#[inline(never)]
fn run<const N: usize>(pc: &mut Exchange, begin: &Begin, points: &[f32]) -> Result<(), HostGone> {
    let design = match Design::<N>::new(&begin.config) {
        Ok(design) => design,
        Err(refusal) => return pc.reply(begin.request, refusal.into()),
    };
    let model_step_s = begin.config.model_step_s();
    let Some(ground) = GroundMotion::new(points, begin.interval_s, model_step_s) else {
        let accepted = "at least a thousandth of the integration step";
        let refused = RefusedParameter::new("motion.interval_s", begin.interval_s, accepted);
        return pc.reply(begin.request, Reply::Refused(refused));
    };
    let mut outer = OuterLoop::new(design);
    let (mut watches, judged, mut orders) = (Watches::new(), Judged::nothing(), OrdersQueue::new());
    let (to_loop, orders) = orders.split();
    let mut from_watch = FromWatch {
        judged: &judged,
        orders,
    };
    let mut watchers = Watchers::new(WatchParts {
        watches: &mut watches,
        judged: &judged,
        orders: to_loop,
    });
    let in_block = steps_in_block(begin.config.timing.rate_hz);
    let mut time = StepTime::new(u32::MAX);
    let watch = SysTick::start(Peripherals::take().ok_or(HostGone)?.SYST);
    let (ticks_per_1024_instructions, overhead_ticks) = watch.ticks_per_1024_instructions();
    let done = |tick, mode| Reply::Done { tick, mode };
    pc.reply(begin.request, done(0, outer.mode()))?;

    let mut hash = Record::<N>::HASH_START;
    let (mut period_stack, mut event_stack) = (0, 0);
    let mut stack = HighWater::paint();
    while let Some((command, sample)) = pc.period::<N>()? {
        if command {
            period_stack = stack.bytes().max(period_stack);
            let (request, command) = pc.command()?;
            let reply = match command {
                Command::Event(event) => {
                    stack = HighWater::paint();
                    let handled = outer.handle(event);
                    event_stack = stack.bytes().max(event_stack);
                    handled.map_or_else(Reply::from, |mode| done(time.steps(), mode))
                }
                Command::Watch(_, told) => match watchers.tell(&told, in_block) {
                    Ok(()) => {
                        outer.watch(told.corrects());
                        done(time.steps(), outer.mode())
                    }
                    Err(refusal) => refusal.into(),
                },
                _ => return Err(HostGone),
            };
            pc.reply(request, reply)?;
            stack = HighWater::paint();
        }
        let begin = watch.now();
        let step = outer.step(&sample, &ground);
        time.add(SysTick::between(begin, watch.now()));
        let output = PeriodReply {
            permit: step.permit,
            command_m: step.command_m,
        };
        hash = step.record.hash(hash);
        let sent_m = step.record.sent_m;
        pc.output(&output, step.record)?;
        // As on a board: first the interrupt's part, after the command, then the tasks'.
        let watched = pass_on(&mut outer, sent_m, &mut from_watch);
        let mut seen = [Seen::default(); MAX_ACTUATORS];
        for (place, seen) in seen.iter_mut().zip(outer.seen()) {
            *place = seen;
        }
        watchers.observe(time.steps(), watched.test, &seen, || 0);
    }
    pc.end(&SessionAccount {
        hash,
        total_ticks: time.total_ticks(),
        steps: time.steps(),
        worst_ticks: time.worst_ticks(),
        ticks_per_1024_instructions,
        overhead_ticks,
        period_stack_bytes: stack.bytes().max(period_stack) as u32,
        event_stack_bytes: event_stack as u32,
        state_bytes: size_of::<OuterLoop<N>>() as u32,
    })
}
