//! `examples/coupled-frame.toml` on the flashed image, as `outerloop run --emulated` does it: the two actuators on one
//! coupler are the first two of the board, and the third has no load.

use crate::example;
use experiment::Experiment;
use experiment::coupled::figures::CoupledFigures;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::summary::{Summary, TestVerdict};
use experiment::trace::{Response, Trace};
use link::Status;
use outerloop_cli::board::Image;
use outerloop_cli::board::emulated::can_run;
use outerloop_core::coupled::INTERFACE_AXIS;
use outerloop_core::{Fault, Mode};
use std::path::Path;

fn experiment(overrides: &[&str]) -> (Experiment, Response) {
    let text = include_str!("../../../examples/coupled-frame.toml");
    let set: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    let test = TestFile::parse(text, "coupled-frame.toml", Path::new(""), &set).unwrap();
    can_run(&test).unwrap();
    assert_eq!(Image::of(&test), Some(Image::Three));
    let experiment = Experiment::new(test, &near_fault(), Some(8.0)).unwrap();
    let ideal = experiment.ideal().unwrap();
    (experiment, ideal)
}

fn on_image(overrides: &[&str]) -> (JudgedRun, Status) {
    let (experiment, ideal) = experiment(overrides);
    let (run, status) = example::run(&experiment, &ideal);
    let board = run.summary.board.as_ref().unwrap();
    println!("{}", board.sentence());
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    (run, status)
}

fn figures(summary: &Summary) -> &CoupledFigures {
    summary.coupled.as_ref().unwrap()
}

#[test]
fn a_test_of_two_coupled_actuators_has_the_figures_of_the_one_without_converters() {
    let (experiment, ideal) = experiment(&[]);
    let plain = experiment
        .run(
            experiment.test.compensation(),
            &ideal,
            1,
            false,
            None::<Trace>,
        )
        .unwrap()
        .summary;
    let (run, status) = on_image(&[]);
    let summary = &run.summary;
    let [on_board, without] = [summary, &plain].map(figures);
    for (coordinate, (a, b)) in on_board.coordinates.iter().zip(
        on_board
            .eps_rms_by_coordinate
            .iter()
            .zip(&without.eps_rms_by_coordinate),
    ) {
        println!("{coordinate}: eps_rms {a:.5}, without converters {b:.5}");
        // Two seeds of the noise already differ by 11 %.
        assert!((a / b - 1.0).abs() < 0.15, "{coordinate}");
    }
    assert_eq!(summary.verdict, TestVerdict::Completed);
    // What was identified of the actuators was transferred bit for bit: the loop on the PC has it.
    assert_eq!(on_board.found.len(), without.found.len());
    for (a, b) in on_board.found.iter().zip(&without.found) {
        println!(
            "{}: {} declared, {} found, {} without converters",
            a.name, a.declared, a.found, b.found
        );
        assert!((a.found / b.found - 1.0).abs() < 0.02, "{a:?} {b:?}");
    }
    // The commands leave 200 us after the sample, 192 us (of 168 cycles each) after the start of the step.
    let timing = summary.board.as_ref().unwrap().timing.unwrap();
    println!(
        "step at most {} cycles; stack {} bytes",
        timing.worst_step_cycles, status.stack_bytes
    );
    assert_eq!(timing.overruns, 0);
    assert!(timing.worst_step_cycles < 24_000);
}

#[test]
fn a_limit_of_one_actuator_and_one_of_the_rotation_trip_with_their_axis_and_permission_falls() {
    for (limit, axis, name) in [
        ("coupled.limits.force_n=500", 0, "actuator 1"),
        (
            "coupled.limits.moment_n_m=30",
            INTERFACE_AXIS + 1,
            "rotation",
        ),
    ] {
        let (run, status) = on_image(&[limit]);
        assert_eq!(run.summary.verdict, TestVerdict::Tripped, "{limit}");
        assert_eq!(figures(&run.summary).trip_axis, Some(name), "{limit}");
        let trip = status.trip.expect("a trip");
        assert_eq!((trip.fault, trip.axis), (Fault::Force, axis), "{limit}");
        assert!(!status.permit && status.mode == Mode::Tripped);
    }
}
