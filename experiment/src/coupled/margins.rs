//! How much later and stronger the loop of two coupled actuators may become before the planned motion is poor.

use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::soundness::planned;
use crate::stability::limits::{StabilityLimit, beyond};
use crate::stability::variation::Variation;
use crate::summary::POOR_EPS_RMS;
use schemars::JsonSchema;
use serde::Serialize;
use std::cell::Cell;

/// Limits of the planned motion, which runs on rigs that the loop is not told of.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct CoupledMargins {
    /// Pure delay of the actuators, ms; of the one that has more, the other is later by as much.
    pub delay: StabilityLimit,
    /// Factor on all gains of the actuators.
    pub gain: StabilityLimit,
}

/// Longest extra delay searched, ms.
const LONGEST_MS: f64 = 32.0;
/// Largest growth of the gains searched, of the present ones.
const LARGEST_GROWTH: f64 = 1.0;
/// Number of bisections, after nine steps at most.
const BISECTIONS: usize = 6;
/// Runs of the loop for both margins, at most.
pub const RUNS: u64 = 2 * (9 + BISECTIONS as u64);

/// Both margins. A motion is poor that is lost or has an error above 10 % rms; if it is poor on the rig as it is, nothing is
/// left. `done` is called with a number of runs of [`RUNS`].
///
/// # Errors
/// A test that cannot run.
pub fn of(e: &Experiment, seed: u64, done: impl Fn(u64) + Sync) -> Result<CoupledMargins, Failure> {
    let actuators = &e.test.coupled_part()?.rig.actuators;
    let present_ms = actuators.delay_ms.into_iter().fold(0.0, f64::max);
    let ideal = e.ideal()?;
    let good = |vary: &Variation| -> Result<bool, Failure> {
        Ok(planned(&e.on_rig(vary), &ideal, seed)?.error() <= POOR_EPS_RMS)
    };
    let now = good(&Variation::NONE)?;
    let search = |from: f64, to: f64, vary: &dyn Fn(f64) -> Variation| {
        let left = Cell::new(RUNS / 2);
        let good = |x: f64| {
            left.set(left.get().saturating_sub(1));
            done(1);
            good(&vary(x))
        };
        let found = match now {
            true => beyond(from, to, BISECTIONS, good),
            false => Ok(Some(0.0)),
        };
        done(left.get());
        found
    };
    let later = |ms: f64| Variation {
        extra_s: 1e-3 * ms,
        ..Variation::NONE
    };
    let stronger = |growth: f64| Variation {
        gain: 1.0 + growth,
        ..Variation::NONE
    };
    let (delay, gain) = rayon::join(
        || search(0.5, LONGEST_MS, &later),
        || search(0.02, LARGEST_GROWTH, &stronger),
    );
    Ok(CoupledMargins {
        delay: StabilityLimit::new(present_ms, delay?.map(|ms| present_ms + ms)),
        gain: StabilityLimit::new(1.0, gain?.map(|growth| 1.0 + growth)),
    })
}
