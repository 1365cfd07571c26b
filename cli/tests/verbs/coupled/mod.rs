//! Tests of two coupled actuators.

mod compensations;
mod many;
mod margins;
mod physics;
mod refusals;
mod results;

use crate::common::root;
use experiment::Experiment;
use experiment::coupled::figures::CoupledFigures;
use experiment::coupled::interface::InterfaceTrace;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::Summary;
use experiment::trace::{Response, Trace};

const EXAMPLE: &str = "examples/coupled-frame.toml";

/// A rig without noise, without the brace, and with ideal actuators.
const EXACT: [&str; 5] = [
    "plant.coupled.ideal=true",
    "plant.coupled.specimen.springs=[]",
    "plant.sensors.displacement_noise_mm=0",
    "plant.sensors.force_noise_n=0",
    "coupled.compensation=none",
];

fn experiment(overrides: &[&str]) -> Experiment {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    let test = TestFile::load_any(&root().join(EXAMPLE), &overrides).unwrap();
    Experiment::new(test, &near_fault(), Some(12.0)).unwrap()
}

fn run(overrides: &[&str]) -> (Experiment, Response, Trace, Summary) {
    let e = experiment(overrides);
    let ideal = e.ideal().unwrap();
    let run = e.run(e.test.compensation(), &ideal, 1, true, ()).unwrap();
    (e, ideal, run.trace.unwrap(), run.summary)
}

/// The part of the record that only two coupled actuators have.
fn interface(record: &Trace) -> &InterfaceTrace {
    record.interface.as_ref().unwrap()
}

fn figures(summary: &Summary) -> &CoupledFigures {
    summary.coupled.as_ref().unwrap()
}
