//! Archives of tests, as a replay loads them.
#![no_main]

use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use fuzz::{begin_with, file_of};
use libfuzzer_sys::fuzz_target;
use outerloop_cli::archive::{FinishedTest, load, to_bytes};
use outerloop_cli::site::RigKind;
use std::path::Path;

fuzz_target!(
    init: begin_with([archived()]),
    |bytes: &[u8]| {
        let _ = load(&file_of(bytes, "h5"));
    }
);

/// An archive with some steps of a test.
fn archived() -> Vec<u8> {
    let text = include_str!("../../examples/table1.toml");
    let test = TestFile::parse(text, "table1.toml", Path::new(""), &[]).expect("the example");
    let experiment = Experiment::new(test, &near_fault(), Some(0.05)).expect("a test");
    let ideal = experiment.ideal().expect("an ideal test");
    let compensation = experiment.test.compensation();
    let ran = experiment
        .run(compensation, &ideal, 1, true, ())
        .expect("a run");
    to_bytes(&FinishedTest {
        experiment: &experiment,
        compensation,
        place: RigKind::Simulated,
        seed: 1,
        orders: &[],
        summary: &ran.summary,
        trace: &ran.trace.expect("its steps"),
    })
    .expect("an archive")
}
