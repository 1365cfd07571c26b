//! Every actuator has its own outputs, limits and faults, and all stop together.

use crate::desk::{ACTUATORS, Bench, Desk, codes};
use emu::{InjectedFault, Log, LoggedEvent, PlannedFault};
use link::Command;
use link::reply::Reply;
use link::telemetry::Input;
use outerloop_core::{Fault, Mode, Trip};

/// A test that trips by a fault of one actuator.
fn tripped(actuator: usize, fault: InjectedFault) -> (Desk, Trip) {
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 900,
            fault,
        }),
        actuator,
        ..Bench::default()
    });
    desk.start();
    desk.until(Mode::Tripped);
    let trip = desk.status().trip.expect("a trip");
    (desk, trip)
}

/// A test with a fault of one actuator: how long PERMIT stayed high, ns, the reason of the trip, and the log.
fn trip(actuator: usize, fault: InjectedFault) -> (u64, Fault, Log) {
    let (mut desk, trip) = tripped(actuator, fault);
    let course = desk.course();
    for _ in 0..200 {
        desk.step();
    }
    (
        course.permit_low_ns - course.fault_ns,
        trip.fault,
        desk.log(),
    )
}

/// Codes of the three outputs in each period since PERMIT went low.
fn since_the_trip(log: &Log) -> Vec<[Option<u16>; ACTUATORS]> {
    let low = log
        .seen
        .iter()
        .rev()
        .find(|s| s.1 == LoggedEvent::Permit(false));
    let low_ns = low.expect("PERMIT goes low").0;
    let periods = log.triggers_ns.iter().filter(|at| **at > low_ns).count();
    let shown = log.pin.iter().zip(&log.other_pins);
    let all: Vec<_> = shown.map(|(a, [b, c])| [*a, *b, *c]).collect();
    // Not the period of the trip itself.
    all[all.len() + 3 - periods..].to_vec()
}

#[test]
fn a_broken_wire_of_any_actuator_trips_within_a_period_and_all_outputs_stand() {
    for actuator in [0, 2] {
        let (permit_ns, fault, log) = trip(actuator, InjectedFault::SensorAtRail);
        println!("actuator {actuator}: {fault:?}, PERMIT low after {permit_ns} ns");
        assert_eq!(fault, Fault::AdcRail);
        assert!(permit_ns <= 500_000, "{permit_ns}");
        let shown = since_the_trip(&log);
        assert!(shown.len() > 150);
        assert!(shown.iter().all(|now| *now == shown[0]), "an output moved");
        // They were in motion: no two of them are equal.
        let [a, b, c] = shown[0].map(Option::unwrap);
        assert!(a != b && b != c, "{a} {b} {c}");
    }
}

#[test]
fn a_sensor_that_freezes_is_noticed_whichever_it_is() {
    let (permit_ns, fault, _) = trip(1, InjectedFault::FrozenSensor);
    println!(
        "PERMIT low {} ms after the second sensor froze",
        permit_ns / 1_000_000
    );
    assert_eq!(fault, Fault::StaleSample);
}

#[test]
fn a_board_says_how_many_actuators_it_has_and_what_each_reads() {
    let mut desk = Desk::new(None);
    desk.start();
    desk.until(Mode::Finished);
    let Reply::Identity(identity) = desk.ask(Command::Identify) else {
        panic!("no identity");
    };
    assert_eq!(identity.actuators(), ACTUATORS);
    assert_eq!(identity.codes, codes());
    let inputs: Vec<Input> = identity.inputs.iter().copied().collect();
    let read_back = [0, 1, 2].map(Input::CommandReadBack);
    assert_eq!(inputs[..3], read_back);
    assert_eq!(inputs[3..], [Input::SecondDisplacement]);
    let status = desk.status();
    assert_eq!(status.other_codes.len(), ACTUATORS - 1);
    // Each floor of a frame moves further than the one below it.
    let line = identity.calibration.displacement;
    let peak = |actuator| {
        let steps = desk.steps.iter();
        let at = steps.filter_map(|(_, s)| s.codes(actuator));
        at.map(|[d, _]| line.quantity(d).abs()).fold(0.0, f32::max)
    };
    let peaks = [0, 1, 2].map(peak);
    println!("peaks of the floors {peaks:?} m");
    assert!(peaks[0] > 0.002 && peaks[0] < peaks[1] && peaks[1] < peaks[2]);
    // The first command, read back at its output by a converter of 12 bits after an amplifier, whose code is 17.6 command codes.
    let command = identity.calibration.command;
    let running: Vec<_> = desk
        .steps
        .iter()
        .map(|(_, s)| s)
        .filter(|s| s.mode() == Some(Mode::Running))
        .collect();
    let off = running
        .iter()
        .map(|s| (command.quantity(s.inputs[0]) - s.command_m).abs());
    let off = off.fold(0.0, f32::max) / command.per_code;
    println!("the first command reads back within {off} codes of 65536");
    assert!(off <= 12.0, "{off} codes");
    // All three move with their outputs: each floor further than the one below it.
    let far = [0, 1, 2].map(|input| span(running.iter().map(|s| s.inputs[input])));
    println!("commands read back over {far:?} codes");
    assert!(far[0] > 2000 && far[0] < far[1] && far[1] < far[2]);
    // The second sensor of the first floor reads like its first.
    assert!(running.iter().all(|s| s.inputs[3] == s.displacement));
}

fn span(codes: impl Iterator<Item = u16> + Clone) -> u16 {
    codes.clone().max().unwrap_or(0) - codes.min().unwrap_or(0)
}

#[test]
fn a_dead_output_of_any_actuator_stands_where_a_dead_valve_leaves_the_command_moving() {
    for actuator in 0..ACTUATORS {
        let [valve, output] = [InjectedFault::DeadValve, InjectedFault::DeadOutput].map(|fault| {
            let (desk, trip) = tripped(actuator, fault);
            // Which check detects it first depends on the phase of the motion.
            let by_motion = [Fault::Tracking, Fault::StaleSample].contains(&trip.fault);
            let by_reading = fault == InjectedFault::DeadOutput && trip.fault == Fault::Output;
            assert!(by_motion || by_reading, "{fault:?}: {:?}", trip.fault);
            let running = desk.steps.iter().map(|(_, s)| s);
            let running = running.filter(|s| s.mode() == Some(Mode::Running));
            let last: Vec<u16> = running.map(|s| s.inputs[actuator]).collect();
            // The last 8 ms before the trip.
            span(last[last.len() - 16..].iter().copied())
        });
        println!(
            "actuator {}: its command read back moves over {valve} codes with a dead valve, {output} with a dead output",
            actuator + 1
        );
        // At most one code of 12 bits, against more than two.
        assert!(output <= 18 && valve > 40, "{valve} {output}");
    }
}
