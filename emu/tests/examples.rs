//! What `outerloop run --emulated` does with each of the examples, on the flashed image with the chip's own converters: the
//! first seconds, or the strong part where peaks exceed the range of an uncalibrated board. Also that a repeated test is the
//! same to the bit, however busy this machine is.

#[path = "common/example.rs"]
mod example;

use experiment::Experiment;
use experiment::files::channels;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::{Summary, TestVerdict};
use outerloop_cli::board::emulated::can_run;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

fn file(name: &str) -> TestFile {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../examples")
        .join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    TestFile::parse(&text, name, Path::new(""), &[]).unwrap()
}

/// Runs the first seconds; returns the peak of the ideal test, m, and the summary. Every step is received and recomputed.
fn run(name: &str, seconds: f64) -> (f64, Summary) {
    let test = file(name);
    can_run(&test).unwrap();
    let experiment = Experiment::new(test, &near_fault(), Some(seconds)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let (run, _) = example::run(&experiment, &ideal);
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

/// Sixteen standard deviations of its sensors' noise fit into the test's own peaks: the ranges must leave room for it.
#[test]
fn the_papers_steel_frame_starts_and_runs_in_its_noise() {
    run("steel-frame.toml", 1.0);
}

#[test]
fn a_frame_whose_first_storey_stands_in_the_laboratory() {
    run("hybrid.toml", 3.0);
}

/// The bits of every channel of a test, and the numbers of its control steps since power-up.
fn bits(experiment: &Experiment) -> (Vec<(String, Vec<u32>)>, Vec<u32>) {
    let ideal = experiment.ideal().unwrap();
    let trace = example::run(experiment, &ideal).0.trace.unwrap();
    let channels = channels::of(&trace).into_iter();
    let of = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect();
    (
        channels.map(|c| (c.name, of(c.values))).collect(),
        trace.tick.clone(),
    )
}

/// The rig is noisy, and all that the board sees of the PC is its bytes at instants of the board's own time.
#[test]
fn a_test_runs_the_same_to_the_bit_again_and_on_a_busy_machine() {
    let experiment = Experiment::new(file("steel-frame.toml"), &near_fault(), Some(0.2)).unwrap();
    let first = bits(&experiment);
    let over = AtomicBool::new(false);
    let busy = std::thread::scope(|s| {
        for _ in 0..4 {
            s.spawn(|| {
                while !over.load(Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        let again = bits(&experiment);
        over.store(true, Relaxed);
        again
    });
    assert!(first.1.len() >= 400, "{} steps", first.1.len());
    assert_eq!(first.1, busy.1, "the start falls into another control step");
    for ((name, was), (_, is)) in first.0.iter().zip(&busy.0) {
        let off = was.iter().zip(is).position(|(was, is)| was != is);
        assert_eq!((off, was.len()), (None, is.len()), "{name}");
    }
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
