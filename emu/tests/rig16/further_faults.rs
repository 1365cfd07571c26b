//! Faults beyond the single ones: a port without its clock, a load cell that is not dead but shows no force, an input converter
//! that is late or does not return, a wrong bit in the ground motion, declared offsets that are wrong.

use crate::desk::{Bench, Desk, TABLE_1, config};
use crate::single_faults::{
    BEYOND_M, PHASES, USUAL, beyond_in_a_test, each, met_in_a_test, run, single, single_of, stated,
    worked_out,
};
use emu::InjectedFault::{
    self, ForceContact, ForceOffset, HummingForce, PortWithoutClock, ResetWithoutInput, SlowInput,
    TurnedPoint,
};
use emu::{LoggedEvent, PlannedFault};
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::TestVerdict;
use experiment::trace::Trace;
use link::Command;
use link::reply::{NotReady, Reply};
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{BoardBench, Operator};
use outerloop_core::{Event, Fault, Mode};
use std::path::Path;

/// A port without its clock cannot drop PERMIT: the watchdog must, by a reset that releases the pins.
#[test]
fn a_port_without_its_clock_keeps_permit_no_longer_than_the_watchdogs_time() {
    for after_steps in [PHASES[1], 300] {
        let mut desk = Desk::with(Bench {
            plan: Some(PlannedFault {
                after_steps,
                fault: PortWithoutClock,
            }),
            ..Bench::default()
        });
        desk.start();
        for _ in 0..1500 {
            desk.turn();
        }
        let log = desk.log();
        let fault_ns = log.seen.iter().find(|s| s.1 == LoggedEvent::Fault);
        let fault_ns = fault_ns.expect("it came").0;
        let since = log.seen.iter().filter(|s| s.0 >= fault_ns);
        let permit: Vec<_> = since
            .filter_map(|(at, seen)| match seen {
                LoggedEvent::Permit(high) => Some((*high, (at - fault_ns) / 1_000_000)),
                _ => None,
            })
            .collect();
        println!("{after_steps} steps: PERMIT and ms {permit:?}");
        assert!(
            matches!(permit[..], [(false, after_ms)] if after_ms <= 50),
            "{permit:?}"
        );
    }
}

/// Missing for 5 ms of 7.5, and for 20 of 30: no single gap is long.
#[test]
fn a_load_cell_whose_contact_is_open_for_two_thirds_of_the_time_trips() {
    let contacts = [
        ForceContact { open: 10, of: 15 },
        ForceContact { open: 40, of: 60 },
    ];
    let mut wrong = each(USUAL, &contacts, &PHASES[..2]);
    // With the program's own limit, a motion of a quarter of the planned peak, it trips by the same count, after a longer way.
    let plan = run(USUAL, None, 0, &stated());
    for contact in contacts {
        let beyond_m = beyond_in_a_test(USUAL, contact, PHASES[0], &plan, &worked_out(&plan));
        println!("worked out, {contact:?}: {:.2} mm", beyond_m * 1e3);
        let trip = met_in_a_test(contact).status().trip.map(|t| t.fault);
        if trip != Some(Fault::ForceStands) {
            wrong.push(format!("{contact:?}: {trip:?}"));
        }
    }
    assert_eq!(wrong, [""; 0]);
}

/// Some 9 mV of hum after a dead load cell: more than its converter's own noise.
#[test]
fn a_load_cell_that_is_dead_and_hums_trips_near_zero() {
    let hums = HummingForce { codes: 29 };
    let mut wrong = each(USUAL, &[hums], &PHASES[..2]);
    let trip = met_in_a_test(hums).status().trip.map(|t| t.fault);
    if trip != Some(Fault::ForceStands) {
        wrong.push(format!("{trip:?}"));
    }
    assert_eq!(wrong, [""; 0]);
}

/// Largest displacement, m, from the position at the command to start, of a test with a fault and a declared offset of its load
/// cell, N, and the reply to that command.
fn started_on(fault: Option<InjectedFault>, declared_n: Option<f64>) -> (f64, Reply) {
    let mut test = config();
    test.limits = stated();
    test.rig.force_offset_n = declared_n.into_iter().collect();
    let mut desk = single_of(USUAL, fault, (0, 0.0), test);
    desk.order(Command::Event(Event::Arm));
    desk.until(Mode::Armed);
    while desk.step().command_m != 0.0 {}
    for _ in 0..100 {
        desk.step();
    }
    let stood = desk.log().position_m.len() - 1;
    let reply = desk.ask(Command::Event(Event::Start));
    // The ground is at rest at first: motion in the first 100 ms is not planned.
    for _ in 0..200 {
        desk.step();
    }
    let at_m = desk.log().position_m;
    let far = at_m[stood..].iter().map(|m| (m - at_m[stood]).abs());
    (far.fold(0.0, f64::max), reply)
}

// proves: obstacle.strained by ForceOffset
/// A test begins at rest: a force at its start moves the structure by itself.
#[test]
fn a_test_whose_load_cell_is_off_by_a_kilonewton_is_not_started() {
    for n in [1000, -1000] {
        let (far_m, reply) = started_on(Some(ForceOffset { n }), None);
        println!("{n} N: {:.2} mm, {reply:?}", far_m * 1e3);
        assert!(far_m <= BEYOND_M, "{far_m} m");
        assert!(
            matches!(&reply, Reply::Refused(r) if r.is(NotReady::Strained)),
            "{reply:?}"
        );
    }
    let (_, reply) = started_on(Some(ForceOffset { n: 50 }), None);
    assert!(matches!(reply, Reply::Done { .. }), "{reply:?}");
}

/// What is judged is the force that the loop integrates. An offset left in the test file after the cell was zeroed moves the
/// structure as an offset of the cell does; one that matches the cell's moves nothing.
#[test]
fn a_test_is_started_by_the_force_that_its_loop_takes_and_not_by_the_one_that_is_read() {
    let (far_m, reply) = started_on(None, Some(1000.0));
    println!("declared alone: {:.2} mm, {reply:?}", far_m * 1e3);
    assert!(far_m <= BEYOND_M, "{far_m} m");
    assert!(
        matches!(&reply, Reply::Refused(r) if r.is(NotReady::Strained) && r.value < -900.0),
        "{reply:?}"
    );
    let (plan_m, _) = started_on(None, None);
    let (far_m, reply) = started_on(Some(ForceOffset { n: 1000 }), Some(1000.0));
    println!(
        "declared and there: {:.2} mm of {:.2}, {reply:?}",
        far_m * 1e3,
        plan_m * 1e3
    );
    assert!(matches!(reply, Reply::Done { .. }), "{reply:?}");
    assert!((far_m - plan_m).abs() < 1e-4, "{far_m} m of {plan_m}");
}

/// The piston's position when the contact closes is computed from what the test declares of the rig, and a wrong figure
/// causes a jump. A wrong command offset cannot be noticed beforehand.
#[test]
fn a_command_that_is_declared_millimetres_off_is_refused() {
    let mut desk = single(USUAL, None, 0, 0.0, &stated());
    let mut test = config();
    test.limits = stated();
    test.limits.tracking_m = Some(0.01);
    test.rig.command_offset_m = [3e-3].into_iter().collect();
    let reply = desk.ask(Command::Configure(test.into()));
    for _ in 0..300 {
        desk.step();
    }
    // What would happen with it.
    desk.order(Command::Event(Event::Arm));
    let stood = desk.log().position_m.len() - 1;
    for _ in 0..200 {
        desk.step();
    }
    let at_m = desk.log().position_m;
    let far = at_m[stood..].iter().map(|m| (m - at_m[stood]).abs());
    let far_m = far.fold(0.0, f64::max);
    println!("declared off: {:.2} mm, {reply:?}", far_m * 1e3);
    assert!(
        matches!(&reply, Reply::Refused(r) if r.name == "rig.command_offset_m" && r.value == 3e-3),
        "{reply:?}"
    );
    assert!(far_m <= BEYOND_M, "{far_m} m");
}

/// BUSY falls after the frame was read: what was read is the previous conversion.
#[test]
fn a_conversion_that_ends_after_its_frame_was_read_is_no_sample() {
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 1300,
            fault: SlowInput,
        }),
        ..Bench::default()
    });
    desk.start();
    for _ in 0..2000 {
        desk.step();
    }
    let trip = desk.status().trip.map(|t| t.fault);
    assert_eq!(trip, Some(Fault::StaleSample));
}

/// If the input converter does not return, the output stays where it was and does not follow a reading of mid-range.
#[test]
fn a_reset_without_an_input_converter_leaves_the_output_where_it_is() {
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: PHASES[1],
            fault: ResetWithoutInput,
        }),
        ..Bench::default()
    });
    desk.start();
    for _ in 0..1500 {
        desk.turn();
    }
    let log = desk.log();
    let reset = log.seen.iter().position(|s| s.1 == LoggedEvent::Reset);
    let reset = reset.expect("it was reset");
    let written = log.seen[reset..].iter();
    let written = written.filter(|s| matches!(s.1, LoggedEvent::Command(_)));
    let written = written.count();
    let low = log.permitted.iter().rposition(|p| *p).expect("it ran");
    let held = log.pin[low].expect("it is shown");
    let last = log.pin.last().copied().flatten().expect("it is shown");
    println!("{written} commands, the output went from {held} to {last}");
    assert!(held.abs_diff(32_768) > 1000, "it stood in the middle");
    assert!(last.abs_diff(held) < 100, "{held} became {last}");
}

/// Another ground motion than the planned one stays inside every limit; its bits differ from the PC's, which stops the test
/// on its ramp.
#[test]
fn a_ground_motion_with_a_wrong_bit_is_stopped_by_the_pc() {
    let test = TestFile::parse(
        TABLE_1,
        "test.toml",
        Path::new(""),
        &["excitation.peak_response_mm=27".to_owned()],
    )
    .unwrap();
    let experiment = Experiment::new(test.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let plan = PlannedMotion::of(&experiment, &ideal);
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 2000,
            fault: TurnedPoint { from: 300 },
        }),
        ..Bench::default()
    });
    desk.calibrate();
    let bench = BoardBench::new(desk.connection(), plan, Operator::not_asked());
    let method = test.config.compensation.kind;
    let run = experiment
        .run_on(&bench, method, &ideal, true, None::<Trace>)
        .unwrap();
    let trace = run.trace.unwrap();
    let apart = trace.floors[0].displacement_m.iter().enumerate();
    let apart_m = apart.map(|(step, m)| (m - ideal.at(step).unwrap()[0]).abs());
    let apart_m = apart_m.fold(0.0, f32::max);
    println!(
        "{} steps, {:.2} mm from the plan, {}",
        trace.len(),
        apart_m * 1e3,
        run.summary.sentence()
    );
    let said = run.summary.board.as_ref().unwrap().sentence();
    println!("{said}");
    assert!(said.contains("otherwise than the PC"), "{said}");
    assert_eq!(run.summary.verdict, TestVerdict::Stopped);
    assert!(apart_m < 2e-3, "{apart_m} m");
}
