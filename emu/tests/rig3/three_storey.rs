//! `examples/three-storey.toml` on the flashed image, as `outerloop run --emulated` does it: its strong part, to the end.

use crate::example;
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::TestVerdict;
use experiment::trace::Trace;
use outerloop_cli::board::Image;
use outerloop_cli::board::emulated::can_run;
use std::path::Path;

#[test]
fn the_error_is_within_5_percent_of_the_one_without_converters() {
    let text = include_str!("../../../examples/three-storey.toml");
    let test = TestFile::parse(text, "three-storey.toml", Path::new(""), &[]).unwrap();
    can_run(&test).unwrap();
    assert_eq!(Image::of(&test), Some(Image::Three));
    let experiment = Experiment::new(test, &near_fault(), Some(8.0)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let method = experiment.test.config.compensation.kind;
    let without = experiment
        .run(method, &ideal, 1, false, None::<Trace>)
        .unwrap();

    let (run, _) = example::run(&experiment, &ideal);

    let (summary, plain) = (&run.summary, &without.summary);
    println!(
        "three actuators, peaks {:.3?} m: eps_rms {:.4}, without converters {:.4}",
        ideal.peaks_m(),
        summary.eps_rms,
        plain.eps_rms
    );
    let board = summary.board.as_ref().unwrap();
    println!("{}", board.sentence());
    assert_eq!(summary.verdict, TestVerdict::Completed);
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    assert!((summary.eps_rms / plain.eps_rms - 1.0).abs() < 0.05);
    // A step and its converters fit into the 80 us before the commands leave, with room: 72 us of 168 cycles.
    let timing = board.timing.unwrap();
    println!("step at most {} cycles", timing.worst_step_cycles);
    assert_eq!(timing.overruns, 0);
    assert!(timing.worst_step_cycles < 10_000);
}
