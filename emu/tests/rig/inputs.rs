//! What an image with one actuator records in addition to displacement and force.

use crate::desk::{Bench, Desk};
use emu::{InjectedFault, PlannedFault};
use link::reply::Reply;
use link::telemetry::Input;
use link::{Calibration, Command};
use outerloop_core::Mode;

/// Largest difference between the command read back and the command sent, m, in a running test with a fault, until it trips.
fn read_back_after(fault: InjectedFault) -> f32 {
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 600,
            fault,
        }),
        ..Bench::default()
    });
    desk.start();
    desk.until(Mode::Tripped);
    let line = Calibration::nominal(&crate::desk::codes()).command;
    let moving = |mode| matches!(mode, Some(Mode::Running));
    let running = desk.steps.iter().filter(|(_, s)| moving(s.mode()));
    running
        .map(|(_, s)| (line.quantity(s.inputs[0]) - s.command_m).abs())
        .fold(0.0, f32::max)
}

#[test]
fn a_dead_output_is_told_from_a_dead_valve_by_the_command_read_back() {
    let valve = read_back_after(InjectedFault::DeadValve);
    let output = read_back_after(InjectedFault::DeadOutput);
    println!("command read back off by {valve} m with a dead valve, {output} m with a dead output");
    let code_m = Calibration::nominal(&crate::desk::codes()).command.per_code;
    assert!(valve <= 2.0 * code_m, "{valve}");
    assert!(output > 1.5e-4 && output > 5.0 * code_m, "{output}");
}

#[test]
fn a_second_displacement_and_the_heads_acceleration_come_with_every_step() {
    let mut desk = Desk::new(None);
    let Reply::Identity(identity) = desk.ask(Command::Identify) else {
        panic!("no identity");
    };
    let inputs: Vec<Input> = identity.inputs.iter().copied().collect();
    assert_eq!(
        inputs,
        [
            Input::CommandReadBack(0),
            Input::SecondDisplacement,
            Input::HeadAcceleration
        ]
    );
    desk.start();
    desk.until(Mode::Finished);
    // The rig's second sensor reads like its first.
    assert!(
        desk.steps
            .iter()
            .all(|(_, s)| s.inputs[1] == s.displacement)
    );
    let [low_v, high_v] = identity.input_span_v;
    let volts = |code| Input::volts(code, identity.codes.sensor_top, [low_v, high_v]);
    let middle_v = f64::from(low_v + high_v) / 2.0;
    let apart = |s: &link::telemetry::StepReport| (volts(s.inputs[2]) - middle_v).abs();
    let peak = desk.steps.iter().map(|(_, s)| apart(s));
    let peak = peak.fold(0.0, f64::max);
    println!("peak acceleration of the head {peak:.3} V");
    assert!(peak > 0.0025 * f64::from(high_v - low_v), "{peak} V");
}
