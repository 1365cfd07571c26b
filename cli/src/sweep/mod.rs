//! The same test over the values of one key, on every ground motion and under every compensation.

pub mod fragility;
pub mod range;
pub mod swept_test;

pub use fragility::Fragility;
pub use range::Range;

use crate::terminal::{Progress, interrupt};
use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use rayon::prelude::*;
use serde::Serialize;
use swept_test::SweptTest;

/// What a sweep came to.
#[derive(Debug, Serialize)]
pub struct SweepResult<'a> {
    /// Path of the key.
    pub path: &'a str,
    /// Each test.
    pub rows: &'a [SweptTest],
    /// The displacement whose exceedance is counted, mm.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub limit_mm: Option<f64>,
    /// The ideal rig's curve, then one for each compensation.
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    pub fragility: &'a [Fragility],
}

/// Runs every pair of experiment and method on all cores; fewer after Ctrl-C. In the order of the experiments.
///
/// # Errors
/// A test that cannot be laid out.
pub fn run(
    experiments: &[(f64, Experiment)],
    compensations: &[Compensation],
    seed: u64,
) -> Result<Vec<SweptTest>, Failure> {
    let steps: usize = experiments.iter().map(|(_, e)| e.control_steps()).sum();
    let progress = Progress::over("sweep", (steps * compensations.len()) as u64);
    let parts: Vec<Vec<SweptTest>> = experiments
        .par_iter()
        .filter(|_| !interrupt::asked())
        .map(|(value, e)| {
            let ideal = e.ideal()?;
            let peaks_m = ideal.peaks_m().into_iter().take(e.floors_in_m());
            let ideal_peak_m = peaks_m.fold(0.0, f64::max);
            let row = |compensation: &Compensation| {
                let run = e.run(*compensation, &ideal, seed, false, progress.observer())?;
                Ok(SweptTest {
                    value: *value,
                    ideal_peak_m,
                    summary: run.summary,
                })
            };
            compensations.iter().map(row).collect()
        })
        .collect::<Result<_, Failure>>()?;
    Ok(parts.into_iter().flatten().collect())
}

/// The worst error of one compensation at one value, over the ground motions: eps_rms; infinite where one was lost.
pub fn worst(rows: &[SweptTest], compensation: &str, value: f64) -> Option<f64> {
    let own = rows
        .iter()
        .filter(|r| r.summary.compensation == compensation && r.value == value);
    own.map(|r| r.summary.error()).reduce(f64::max)
}
