//! What this image records beside displacement and force.

use crate::desk::{Bench, Desk};
use emu::{Fault, Planned};
use link::reply::{Obstacle, Reply};
use link::telemetry::Input;
use link::{Calibration, Command};
use outerloop_core::{Event, Mode};

/// Largest distance of the command as read back from the command as sent, in codes, after a fault in mid test and until
/// the test trips.
fn read_back_after(fault: Fault) -> f32 {
    let mut desk = Desk::with(Bench {
        plan: Some(Planned {
            after_steps: 600,
            fault,
        }),
        ..Bench::default()
    });
    desk.start();
    desk.until(Mode::Tripped);
    let line = Calibration::placeholder(&crate::desk::codes()).command;
    let moving = |state| matches!(state, Some(Mode::Running));
    let running = desk.steps.iter().filter(|(_, s)| moving(s.state()));
    running
        .map(|(_, s)| (line.quantity(s.inputs[0]) - s.command_m).abs() / line.per_code)
        .fold(0.0, f32::max)
}

#[test]
fn a_dead_output_is_told_from_a_dead_valve_by_the_command_read_back() {
    let valve = read_back_after(Fault::DeadValve);
    let output = read_back_after(Fault::DeadOutput);
    println!(
        "command read back off by {valve} codes with a dead valve, {output} with a dead output"
    );
    assert!(valve <= 2.0, "{valve}");
    assert!(output > 100.0, "{output}");
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
            Input::CommandReadBack,
            Input::SecondDisplacement,
            Input::HeadAcceleration
        ]
    );
    desk.start();
    desk.until(Mode::Finished);
    // The rig's second sensor is as its first.
    assert!(
        desk.steps
            .iter()
            .all(|(_, s)| s.inputs[1] == s.displacement)
    );
    let volts = |code| Input::volts(code, identity.codes.sensor_top);
    let peak = desk.steps.iter().map(|(_, s)| volts(s.inputs[2]).abs());
    let peak = peak.fold(0.0, f64::max);
    println!("peak acceleration of the head {peak:.3} V");
    assert!(peak > 0.05, "{peak} V");
}

#[test]
fn a_converter_without_its_reset_does_not_answer_and_nothing_can_be_armed() {
    use emu::registers::GPIOF_MODER;
    let mut desk = Desk::with(Bench {
        mutant: Some(emu::Mutant {
            address: GPIOF_MODER,
            clear: 3 << 24,
            set: 0,
        }),
        ..Bench::default()
    });
    desk.load();
    assert!(!desk.status().converters_ok);
    let reply = desk.ask(Command::Event(Event::Arm));
    let silent = Some(Obstacle::Converters);
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == silent),
        "{reply:?}"
    );
}
