//! What the rig watch does to the loop: when its orders come into force, and how it stops a test.
#![allow(missing_docs)]

mod common;

use common::{Rig, shaking, table1};
use outerloop_core::watch::{Alarm, AxisOrders, Block, BlockId, Orders, State, Taps, WatchedStep};
use outerloop_core::{Design, Event, Fault, GroundMotion, Method, Mode, OuterLoop, Record, flag};
use std::collections::VecDeque;

const RECORD_S: f64 = 6.0;

/// Answers on their way.
type Answers = VecDeque<(BlockId, Orders<1>)>;

/// What is done behind each step: the answer that is due, and the block that the step fills.
fn behind_step(
    outer: &mut OuterLoop<1>,
    answers: &mut Answers,
    taps: &mut Taps<1>,
) -> Option<(BlockId, [Block; 1])> {
    let WatchedStep { test, due } = outer.count_watched()?;
    if let Some(due) = due {
        match answers.pop_front() {
            Some((answered, orders)) => {
                assert_eq!(answered, due, "in turn");
                outer.obey(|in_force| *in_force = orders);
            }
            None => outer.end_watch(),
        }
    }
    taps.add(test, true, outer.seen().iter())
}

fn ground(points: &[f32]) -> GroundMotion<'_> {
    GroundMotion::new(points, 0.01, 5e-4).unwrap()
}

/// A test whose watch asks for more lead, another scale and a later reading by what it sees, and takes its blocks up so many
/// blocks late; at the end it gives an alarm. The hash of all records, and the flags and mode at the end.
fn watched(behind: usize, answered: bool) -> (u64, u32, OuterLoop<1>) {
    let points = shaking(RECORD_S);
    let mut config = table1();
    config.compensation.kind = Method::from_name("paper+inverse").unwrap();
    config.compensation.delay_ms = 3.0.into();
    let mut rig = Rig::new(8);
    let mut outer = OuterLoop::new(Design::new(&config).unwrap());
    outer.watch(true);
    rig.step(&mut outer, &ground(&points));
    outer.handle(Event::Arm).unwrap();
    rig.step(&mut outer, &ground(&points));
    outer.handle(Event::Start).unwrap();
    let (mut hash, mut flags, mut first) = (Record::<1>::HASH_START, 0, None);
    // Four control steps are a block.
    let (mut taps, mut full) = (Taps::<1>::of(4), VecDeque::new());
    let mut answers = Answers::new();
    for i in 0..8000_usize {
        let record = rig.step(&mut outer, &ground(&points)).record;
        (hash, flags) = (record.hash(hash), record.flags);
        if flags & flag::ADJUSTED != 0 {
            first.get_or_insert(i);
        }
        full.extend(behind_step(&mut outer, &mut answers, &mut taps));
        if i / 4 < behind || i % 4 != 3 || !answered {
            continue;
        }
        if let Some((of, [block])) = full.pop_front() {
            let mut orders = Orders::NONE;
            let mm = 1e3 * block.displacement_m;
            orders.axes[0] = AxisOrders {
                lead_steps: 2.0 + 0.1 * mm,
                command_scale: 1.0 + 1e-3 * mm,
                reading_late_steps: 0.1 * mm,
                hold: false,
            };
            orders.state = State::Named;
            answers.push_back((of, orders));
        }
    }
    // Block 0 is answered at the end of block 8.
    assert!(first.is_none_or(|step| step == 4 * 9), "{first:?}");
    (hash, flags, outer)
}

#[test]
fn the_watch_changes_the_loop_at_the_same_step_however_soon_its_thread_is_done() {
    let (soon, flags, outer) = watched(0, true);
    assert_eq!(outer.mode(), Mode::Running);
    let named = (State::Named as u32) << flag::WATCH_STATE_SHIFT;
    let of_the_watch =
        3 << flag::WATCH_STATE_SHIFT | flag::ADJUSTED | flag::GUARDED | flag::WATCH_LATE;
    assert_eq!(flags & of_the_watch, flag::ADJUSTED | named);
    for behind in [1, 5, 7] {
        assert_eq!(watched(behind, true).0, soon, "{behind} blocks behind");
    }
    let (late, flags, outer) = watched(8, true);
    assert!(late != soon && flags & flag::WATCH_LATE != 0);
    assert_eq!(outer.mode(), Mode::Running, "the test goes on");
    let (_, flags, _) = watched(0, false);
    assert!(flags & (flag::WATCH_LATE | flag::ADJUSTED) == flag::WATCH_LATE);
}

/// A test under a watch that stops it with this alarm: the command sent then, the one after it, and the loop.
fn stopped_by(alarm: Alarm) -> ([[f32; 1]; 2], bool, OuterLoop<1>) {
    let points = shaking(RECORD_S);
    let mut rig = Rig::new(8);
    let mut outer = OuterLoop::new(Design::new(&table1()).unwrap());
    outer.watch(false);
    for event in [Event::Arm, Event::Start] {
        rig.step(&mut outer, &ground(&points));
        outer.handle(event).unwrap();
    }
    let (mut steps, mut taps, mut answers) = (0, Taps::<1>::of(4), Answers::new());
    let sent_m = loop {
        let step = rig.step(&mut outer, &ground(&points));
        let (sent_m, permit) = (step.command_m, step.permit);
        steps += 1;
        // Before this step the watch has not stopped it.
        assert!(permit);
        if let Some((of, blocks)) = behind_step(&mut outer, &mut answers, &mut taps) {
            let mut orders = Orders::NONE;
            orders.alarm = (blocks[0].displacement_m.abs() > 1e-3).then_some(alarm);
            answers.push_back((of, orders));
        }
        if !outer.mode().integrates() {
            break sent_m;
        }
        assert!(steps < 8000);
    };
    let trip = outer.trip().unwrap();
    assert_eq!(
        (trip.fault, trip.value, trip.limit),
        (Fault::Watch, alarm.value, alarm.limit)
    );
    assert_eq!(trip.tick + 1, outer.tick(), "the step behind which it came");
    let after = rig.step(&mut outer, &ground(&points));
    ([sent_m, after.command_m], after.permit, outer)
}

// proves: fault.watch by orders.alarm
#[test]
fn a_sensor_that_stands_stops_a_test_at_once() {
    let alarm = Alarm {
        axis: 0,
        value: 0.0,
        limit: 0.0,
    };
    let ([sent_m, after_m], permit, outer) = stopped_by(alarm);
    assert_eq!((outer.mode(), permit), (Mode::Tripped, false));
    assert_eq!(after_m, sent_m, "it stands");
}

/// A command that stops in one step is harder on the specimen than a test that is worth nothing.
#[test]
fn an_error_that_is_foreseen_ends_a_test_on_the_ramp() {
    let alarm = Alarm {
        axis: 0,
        value: 0.2,
        limit: 0.1,
    };
    let ([sent_m, after_m], permit, mut outer) = stopped_by(alarm);
    assert_eq!((outer.mode(), permit), (Mode::Stopping, true));
    assert_ne!(after_m, sent_m, "it goes on to a standstill");
    let (mut rig, mut last_m) = (Rig::new(8), after_m);
    // A ramp of 5 m/s^2 at 2 kHz: its speed falls by 1.25 um a step in each step.
    let mut speed_m = (after_m[0] - sent_m[0]).abs();
    while outer.mode() == Mode::Stopping {
        let next_m = rig.step(&mut outer, &GroundMotion::none()).command_m;
        let step_m = (next_m[0] - last_m[0]).abs();
        assert!(step_m <= speed_m + 1e-7, "{step_m} behind {speed_m}");
        (last_m, speed_m) = (next_m, step_m);
    }
    assert_eq!(outer.mode(), Mode::Tripped);
    assert!(speed_m < 3e-6, "{speed_m}");
}
