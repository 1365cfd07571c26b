//! What `outerloop run --emulated` does with each of the examples, on the flashed image with the chip's own converters: the
//! first seconds, or the strong part where peaks lie beyond what a board shows that nobody has calibrated.

#[path = "common/example.rs"]
mod example;

use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::{Summary, TestVerdict};
use outerloop_cli::board::emulated::can_run;
use std::path::Path;

fn file(name: &str) -> TestFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../examples")
        .join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    TestFile::parse(&text, name, Path::new(""), &[]).unwrap()
}

/// Runs the first seconds; gives the peak of the ideal test, m, and what became of it. Every step is received and worked
/// out again.
fn run(name: &str, seconds: f64) -> (f64, Summary) {
    let test = file(name);
    can_run(&test).unwrap();
    let experiment = Experiment::new(test, &near_fault(), Some(seconds)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let run = example::run(&experiment, &ideal);
    let summary = run.summary;
    println!("{name}: {}", summary.sentence());
    let board = summary.board.as_ref().unwrap();
    assert_eq!(summary.verdict, TestVerdict::Completed, "{name}");
    assert_eq!((board.steps_lost, board.steps_different), (0, 0), "{name}");
    (ideal.peaks_m()[0], summary)
}

#[test]
fn the_strong_part_of_table_1_on_a_board_that_is_calibrated_to_its_rig() {
    let (peak_m, summary) = run("table1.toml", 8.0);
    assert!(peak_m > 0.08 && summary.eps_rms < 0.02);
}

/// Its sensors show sixteen standard deviations of noise within the test's own peaks: the ranges have to leave room for them.
#[test]
fn the_papers_steel_frame_starts_and_runs_in_its_noise() {
    run("steel-frame.toml", 1.0);
}

#[test]
fn a_frame_whose_first_storey_stands_in_the_laboratory() {
    run("hybrid.toml", 3.0);
}

#[test]
fn two_actuators_or_three_of_12_bits_are_refused_in_one_sentence_before_anything_is_built() {
    let refused = |change: fn(&mut TestFile)| {
        let mut test = file("three-storey.toml");
        change(&mut test);
        can_run(&test).unwrap_err().to_string()
    };
    let two = refused(|t| t.config.structure.physical_storeys = Some(2));
    assert!(two.contains("2 storeys in the laboratory"), "{two}");
    let coarse = refused(|t| t.board.converter_bits = Some(12));
    assert!(coarse.contains("board.converter_bits = 12"), "{coarse}");
    assert_eq!((two.lines().count(), coarse.lines().count()), (1, 1));
}
