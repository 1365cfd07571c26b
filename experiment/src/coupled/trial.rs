//! A test of two coupled actuators on the simulated rig, with what only such a test leaves.

use super::table::CoupledCompensation;
use super::trace::{CoupledTrace, InBothCoordinates};
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::judged::JudgedRun;
use crate::trace::Response;

/// How a test ended, and what it left.
#[derive(Clone, Debug)]
pub struct Trial {
    /// Its record, in both systems of coordinates.
    pub record: CoupledTrace,
    /// What every test leaves.
    pub run: JudgedRun,
}

/// Runs the test under a compensation. `keep`: every step is kept for an archive, too.
///
/// # Errors
/// A test of another kind; a rig or a loop that is refused.
pub fn run(
    experiment: &Experiment,
    kind: CoupledCompensation,
    ideal: &Response,
    seed: u64,
    keep: bool,
) -> Result<Trial, Failure> {
    let part = experiment.test.coupled_part()?;
    let mut observer = InBothCoordinates::of(part, experiment.test.config.timing.rate_hz);
    let run = experiment.run(kind, ideal, seed, keep, &mut observer)?;
    Ok(Trial {
        record: observer.trace,
        run,
    })
}
