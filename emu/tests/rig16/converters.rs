//! A converter outside the chip that is not as it was when the board started.

use crate::desk::{Bench, Desk};
use emu::{InjectedFault, PlannedFault};
use link::Command;
use link::reply::{Obstacle, Reply};
use outerloop_core::{Event, Fault, Mode};

/// A rig that has sunk by some millimetres, and a fault that is there from the first sample on. Gives the board with a test
/// in it.
fn loaded(fault: InjectedFault) -> Desk {
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 0,
            fault,
        }),
        sinks_m_per_s: 0.02,
        ..Bench::default()
    });
    desk.load();
    desk
}

/// Arming is refused for this reason, and nothing has moved but what sinks.
fn refuses(fault: InjectedFault, reason: Fault) {
    let mut desk = loaded(fault);
    let reply = desk.ask(Command::Event(Event::Arm));
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == Some(Obstacle::Fault(reason))),
        "{fault:?}: {reply:?}"
    );
    for _ in 0..100 {
        desk.step();
    }
    let at_m = desk.log().position_m;
    let jump_m = at_m.windows(2).map(|w| (w[1] - w[0]).abs());
    assert!(jump_m.fold(0.0, f64::max) < 2e-5, "{fault:?}");
}

#[test]
fn an_output_converter_that_has_lost_its_supply_for_a_moment_is_not_armed() {
    refuses(InjectedFault::OutputDips, Fault::Output);
}

// proves: fault.stale_sample, obstacle.fault by StuckData
#[test]
fn a_data_line_that_is_dead_or_stuck_gives_no_sample_and_nothing_is_armed() {
    for high in [false, true] {
        refuses(InjectedFault::StuckData { high }, Fault::StaleSample);
    }
}

#[test]
fn an_input_converter_that_has_lost_its_supply_gives_no_sample() {
    refuses(InjectedFault::InputDips, Fault::StaleSample);
}

#[test]
fn a_word_that_comes_too_late_shifts_no_later_frame() {
    let mut desk = loaded(InjectedFault::LateWord);
    // The force would stand in the place of the displacement, and the known voltage in nobody's.
    assert!(desk.steps.iter().all(|(_, s)| s.displacement != s.force));
    desk.order(Command::Event(Event::Arm));
    desk.until(Mode::Armed);
}

/// In a running test: the reason, and how far the piston went after the fault, m, beyond the command of then.
fn trips(fault: InjectedFault) -> (Option<Fault>, f64) {
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 1300,
            fault,
        }),
        ..Bench::default()
    });
    desk.start();
    desk.until(Mode::Tripped);
    let course = desk.course();
    println!(
        "{fault:?}: PERMIT low {} us after it",
        (course.permit_low_ns - course.fault_ns) / 1000
    );
    let trip = desk.status().trip.map(|t| t.fault);
    (trip, (course.permit_low_ns - course.fault_ns) as f64 * 1e-9)
}

// proves: fault.output by OutputDips
#[test]
fn an_output_that_drops_to_ground_in_a_running_test_trips_before_the_rig_is_far() {
    let (reason, after_s) = trips(InjectedFault::OutputDips);
    assert_eq!(reason, Some(Fault::Output));
    // The timeout of four steps, the step of the fault and the one that sees it.
    assert!(after_s < 4e-3, "{after_s}");
}

// proves: fault.stale_sample by StuckData
#[test]
fn a_data_line_that_dies_in_a_running_test_trips_as_stale() {
    let (reason, after_s) = trips(InjectedFault::StuckData { high: false });
    assert_eq!(reason, Some(Fault::StaleSample));
    assert!(after_s < 0.013, "{after_s}");
}
