//! The same test many times: over the values of one key, or on rigs drawn around the declared one.

pub mod range;

pub use range::Range;

use crate::terminal::{Progress, interrupt};
use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use experiment::summary::Summary;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// One of many tests.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct OneOfMany {
    /// The value of the key, or the number of a drawn rig, from 0.
    pub value: f64,
    /// Largest displacement of any floor on an ideal rig, m.
    pub ideal_peak_m: f64,
    /// The test.
    #[serde(flatten)]
    pub summary: Summary,
}

/// The result of tests on drawn rigs.
#[derive(Debug, Serialize, JsonSchema)]
pub struct Outcome {
    /// Under which compensation.
    #[serde(skip)]
    pub compensation: &'static str,
    /// Number of tests.
    pub tests: usize,
    /// Cores that they ran on.
    pub threads: usize,
    /// Seconds on the wall clock.
    pub wall_s: f64,
    /// Tests per second of this time.
    pub tests_per_s: f64,
    /// Control steps per second of this time.
    pub control_steps_per_s: f64,
    /// Tests that ran to their end.
    pub completed: usize,
    /// The error that half of the tests stay below; infinite (null in JSON): lost.
    pub eps_rms_median: f64,
    /// The error that 95 % of the tests stay below.
    pub eps_rms_95: f64,
    /// The largest error.
    pub eps_rms_worst: f64,
}

/// Runs every experiment under every compensation on all cores; fewer after Ctrl-C. `lay_out` gives the experiments of a
/// group with their values. Their ideals are computed together, so they may differ only in the rig. Results are in the
/// order of the groups.
///
/// # Errors
/// An experiment that cannot be run.
pub fn run(
    groups: usize,
    lay_out: impl Fn(usize) -> Result<Vec<(f64, Experiment)>, Failure> + Sync,
    compensations: &[Compensation],
    seed: impl Fn(f64) -> u64 + Sync,
    progress: &Progress,
) -> Result<Vec<OneOfMany>, Failure> {
    let group = |group: usize| -> Result<Vec<OneOfMany>, Failure> {
        let experiments = lay_out(group)?;
        let ideals = match &experiments[..] {
            [(_, one)] => vec![one.ideal()?],
            several => {
                let tests: Vec<_> = several.iter().map(|(_, e)| e).collect();
                let first = tests.first().map(|first| first.ideals(&tests));
                first.transpose()?.unwrap_or_default()
            }
        };
        let mut rows = Vec::new();
        for ((value, e), ideal) in experiments.iter().zip(&ideals) {
            let peaks_m = ideal.peaks_m().into_iter().take(e.floors_in_m());
            let ideal_peak_m = peaks_m.fold(0.0, f64::max);
            for compensation in compensations {
                let run = e.run(
                    *compensation,
                    ideal,
                    seed(*value),
                    false,
                    progress.observer(),
                )?;
                rows.push(OneOfMany {
                    value: *value,
                    ideal_peak_m,
                    summary: run.summary,
                });
            }
        }
        Ok(rows)
    };
    let groups = (0..groups).into_par_iter();
    let parts: Vec<Vec<OneOfMany>> = groups
        .filter(|_| !interrupt::asked())
        .map(group)
        .collect::<Result<_, Failure>>()?;
    Ok(parts.into_iter().flatten().collect())
}

/// The worst error, eps_rms, of one compensation at one value, over the ground motions; infinite if one was lost.
pub fn worst(rows: &[OneOfMany], compensation: &str, value: f64) -> Option<f64> {
    let own = rows
        .iter()
        .filter(|r| r.summary.compensation == compensation && r.value == value);
    own.map(|r| r.summary.error()).reduce(f64::max)
}
