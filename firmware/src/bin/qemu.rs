//! The image for QEMU's `netduinoplus2`: one session with the PC over the emulator's standard input and output.
//!
//! Exit status: 0 the session was closed by the PC, 1 the PC went away, 2 panic, 3 fault.

#![no_std]
#![no_main]

use core::fmt::Write;
use cortex_m::Peripherals;
use firmware::board::qemu::{Exchange, Lost, SysTick, exit};
use firmware::board::stack::HighWater;
use firmware::session::{Answer, Header, MAX_POINTS, MAX_REFUSAL, Summary};
use firmware::step_time::StepTime;
use heapless::String;
use outerloop_core::{Config, Design, Fault, GroundMotion, OuterLoop, Record};

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut POINTS: [f32; MAX_POINTS] = [0.0; MAX_POINTS];
    exit(match session(POINTS) {
        Ok(()) => 0,
        Err(Lost) => 1,
    })
}

fn session(points: &mut [f32]) -> Result<(), Lost> {
    let mut pc = Exchange::open()?;
    let (header, config) = pc.begin(points)?;
    let points = points.get(..header.points as usize).ok_or(Lost)?;
    let Some(config) = config else {
        return refuse(
            &mut pc,
            format_args!("the configuration cannot be read: accepted is the one of this version"),
        );
    };
    match header.dof {
        1 => run::<1>(&mut pc, &header, &config, points),
        2 => run::<2>(&mut pc, &header, &config, points),
        3 => run::<3>(&mut pc, &header, &config, points),
        n => refuse(
            &mut pc,
            format_args!("{n} degrees of freedom are refused: accepted are 1 to 3"),
        ),
    }
}

/// The session of a loop with `N` degrees of freedom.
#[inline(never)]
fn run<const N: usize>(
    pc: &mut Exchange,
    header: &Header,
    config: &Config,
    points: &[f32],
) -> Result<(), Lost> {
    let design = match Design::<N>::new(config) {
        Ok(design) => design,
        Err(refusal) => return refuse(pc, format_args!("{refusal}")),
    };
    let Some(ground) = GroundMotion::new(points, header.point_interval_s, config.model_step_s())
    else {
        return refuse(
            pc,
            format_args!(
                "a ground motion with a point every {} s is refused: accepted is 0.001 of an integration step and more",
                header.point_interval_s
            ),
        );
    };
    let mut outer = OuterLoop::new(design);
    let (mut time, mut late) = (StepTime::new(header.deadline_ticks), false);
    let watch = SysTick::start(Peripherals::take().ok_or(Lost)?.SYST);
    let (ticks_per_1024_instructions, overhead_ticks) = watch.ticks_per_1024_instructions();
    pc.reply(&String::new())?;

    let mut hash = Record::<N>::HASH_START;
    let (mut period_stack, mut event_stack) = (0, 0);
    let mut stack = HighWater::paint();
    while let Some((event, mut sample)) = pc.period::<N>()? {
        let mut rejected = false;
        if let Some(event) = event {
            period_stack = stack.bytes().max(period_stack);
            stack = HighWater::paint();
            rejected = outer.handle(event).is_err();
            event_stack = stack.bytes().max(event_stack);
            stack = HighWater::paint();
        }
        if late {
            sample.fault = sample.fault.or(Some(Fault::DeadlineMissed));
        }
        let begin = watch.now();
        let step = outer.step(&sample, &ground);
        late = !time.add(SysTick::between(begin, watch.now()));
        let answer = Answer {
            rejected,
            permit: step.permit,
            command_m: step.command_m,
        };
        hash = step.record.hash(hash);
        pc.answer(&answer, step.record)?;
    }
    pc.end(&Summary {
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

/// Closes the session before it begins, with the reason; what does not fit of it is cut.
fn refuse(pc: &mut Exchange, reason: core::fmt::Arguments<'_>) -> Result<(), Lost> {
    let mut text = String::<MAX_REFUSAL>::new();
    let _ = text.write_fmt(reason);
    pc.reply(&text)
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    exit(2)
}

#[cortex_m_rt::exception]
unsafe fn HardFault(_: &cortex_m_rt::ExceptionFrame) -> ! {
    exit(3)
}
