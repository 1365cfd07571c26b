//! An external converter that has failed since the board started.

#[path = "refused.rs"]
mod refused;

use crate::desk::{Bench, Desk, config};
use emu::{InjectedFault, PlannedFault, ResetLine};
use link::Command;
use link::command::{CommissioningSignal, SignalShape};
use link::reply::{Obstacle, Reply};
use outerloop_core::{Event, Fault, Mode};
use refused::{loaded, refuses, refuses_in_the_middle};

#[test]
fn an_output_converter_that_has_lost_its_supply_for_a_moment_is_not_armed() {
    refuses(InjectedFault::OutputDips, Obstacle::Fault(Fault::Output));
}

#[test]
fn an_output_converter_that_has_lost_its_supply_in_the_middle_of_the_stroke_is_not_armed() {
    refuses_in_the_middle(InjectedFault::OutputDips, Obstacle::Fault(Fault::Output));
}

// proves: fault.stale_sample, obstacle.fault by StuckData
#[test]
fn a_data_line_that_is_dead_or_stuck_gives_no_sample_and_nothing_is_armed() {
    for high in [false, true] {
        let stale = Obstacle::Fault(Fault::StaleSample);
        refuses(InjectedFault::StuckData { high }, stale);
    }
}

/// In these frames every sensor reads the middle of its range with some noise, and so does the command, if that is sent there:
/// nothing but the known voltage shows that they are none.
#[test]
fn a_data_line_that_is_open_and_picks_up_noise_gives_no_sample_and_nothing_is_armed() {
    let stale = Obstacle::Fault(Fault::StaleSample);
    refuses(InjectedFault::OpenData, stale);
}

/// The output holds, and reads back as sent while the rig stands.
#[test]
fn an_output_whose_bus_its_reset_line_has_cleared_is_not_armed() {
    let line = InjectedFault::ResetLine(ResetLine::OutputBus);
    refuses_in_the_middle(line, Obstacle::Fault(Fault::Output));
}

/// A new test asks for the actuator's position before the missing samples have lasted as long as its limit allows.
#[test]
fn a_test_whose_loop_has_seen_no_sample_is_not_armed() {
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 0,
            fault: InjectedFault::StuckData { high: false },
        }),
        ..Bench::default()
    });
    desk.calibrate();
    // The board had lost the PC; this blocks arming for a while.
    desk.pc.forget_steps();
    for _ in 0..300 {
        desk.step();
    }
    let mut config = config();
    config.limits.stale_steps = Some(500);
    desk.order(Command::Configure(config.into()));
    desk.order(Command::Signal(Some(CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Sine { frequency_hz: 5.0 },
        amplitude_m: 0.002,
        seconds: 1.5,
    })));
    let reply = desk.ask(Command::Event(Event::Arm));
    let stale = Some(Obstacle::Fault(Fault::StaleSample));
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == stale),
        "{reply:?}"
    );
    assert!(!desk.log().permitted.contains(&true));
}

#[test]
fn an_input_converter_that_has_lost_its_supply_gives_no_sample() {
    let stale = Obstacle::Fault(Fault::StaleSample);
    refuses(InjectedFault::InputDips, stale);
}

#[test]
fn a_word_that_comes_too_late_shifts_no_later_frame() {
    let mut desk = loaded(InjectedFault::LateWord);
    // Otherwise the force would be in the place of the displacement, and the known voltage in none.
    assert!(desk.steps.iter().all(|(_, s)| s.displacement != s.force));
    desk.order(Command::Event(Event::Arm));
    desk.until(Mode::Armed);
}

/// A fault in a running test: the reason of the trip, and the time from the fault to PERMIT low, s.
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
    // The timeout of four steps, the step of the fault and the one that detects it.
    assert!(after_s < 4e-3, "{after_s}");
}

// proves: fault.stale_sample by StuckData
#[test]
fn a_data_line_that_dies_in_a_running_test_trips_as_stale() {
    let (reason, after_s) = trips(InjectedFault::StuckData { high: false });
    assert_eq!(reason, Some(Fault::StaleSample));
    assert!(after_s < 0.013, "{after_s}");
}
