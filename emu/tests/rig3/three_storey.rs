//! `examples/three-storey.toml` on the flashed image, as `outerloop run --emulated` does it: its first 8 s, with the strong part.

use crate::{example, load};
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::TestVerdict;
use experiment::trace::Trace;
use experiment::watch::NamedCause;
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
    // A step and its converters fit well into the 80 us before the commands leave: 72 us of 168 cycles each remain.
    let timing = board.timing.unwrap();
    println!("step at most {} cycles", timing.worst_step_cycles);
    assert_eq!(timing.overruns, 0);
    assert!(timing.worst_step_cycles < 10_000);
}

/// Three watches with everything on: an adaptive compensation on each actuator, held by the watch; a late sensor that may be
/// corrected for; and the link full of telemetry.
#[test]
fn three_watches_at_work_leave_the_step_its_deadline_and_take_little_of_the_processor() {
    const JUMP: &str = "[declared.actuator]\ngain = { value = 1, tolerance = 0.005 }\ndelay_ms = { value = 4, tolerance = 0.3 }\n\
        lag_ms = { value = 0, tolerance = 0 }\n[watch]\ncorrect = ['late_sensor']\n\
        [[plant.effects]]\nname = 'delay_error'\ndelay_ms = 3\naxis = 1\nfrom_s = 3\n";
    let text = include_str!("../../../examples/three-storey.toml");
    let set = ["compensation.kind='ats'".to_owned()];
    let test = TestFile::parse(&format!("{text}{JUMP}"), "t.toml", Path::new(""), &set).unwrap();
    let experiment = Experiment::new(test, &near_fault(), Some(5.0)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let (run, status) = example::run(&experiment, &ideal);
    let board = run.summary.board.as_ref().unwrap();
    let watch = run.summary.watch.as_ref().unwrap();
    println!("{}\n{}", board.sentence(), watch.sentence());
    assert_eq!(run.summary.verdict, TestVerdict::Completed);
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    let jumped = |c: &NamedCause| (c.name, c.actuator) == ("delay_error", Some(1));
    let held = watch.events.iter().find(|e| e.held).expect("held");
    assert!(held.set.iter().any(jumped), "{held:?}");
    let timing = board.timing.unwrap();
    assert_eq!(timing.overruns, 0);
    assert!(timing.worst_step_cycles < 10_000);
    // Two per cent for each.
    let [mean, worst] = load::of_the_watch(&status);
    assert!(mean < 3.0 * 2.0 && worst < 100.0);
}
