//! How much later and stronger the loop of two coupled actuators may become before the planned motion is poor.

use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::soundness::{SoundnessVerdict, planned};
use crate::stability::limits::StabilityLimit;
use crate::stability::variation::Variation;
use crate::summary::POOR_EPS_RMS;
use schemars::JsonSchema;
use serde::Serialize;
use std::cell::Cell;

/// Limits of the planned motion, which runs on rigs that the loop is not told of.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
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

/// Both margins. A motion is poor that is lost or has an error above 10 % rms; one that is poor on the rig as it is has no margins,
/// nor has a test with the `verdict` unstable. `done` is called with a number of runs of [`RUNS`].
///
/// # Errors
/// A test that cannot run.
pub fn of(
    e: &Experiment,
    verdict: SoundnessVerdict,
    seed: u64,
    done: impl Fn(u64) + Sync,
) -> Result<CoupledMargins, Failure> {
    let actuators = &e.test.coupled_part()?.rig.actuators;
    let present_ms = actuators.delay_ms.into_iter().fold(0.0, f64::max);
    let ideal = e.ideal()?;
    let good = |vary: &Variation| -> Result<bool, Failure> {
        Ok(planned(&e.on_rig(vary), &ideal, seed)?.error() <= POOR_EPS_RMS)
    };
    let none = if verdict == SoundnessVerdict::Unstable {
        Some("the test is unstable")
    } else if !good(&Variation::NONE)? {
        Some("the planned motion is poor on the rig as it is")
    } else {
        None
    };
    let search = |present: f64,
                  (from, to): (f64, f64),
                  value: &dyn Fn(f64) -> f64,
                  vary: &dyn Fn(f64) -> Variation| {
        let left = Cell::new(RUNS / 2);
        let good = |x: f64| {
            left.set(left.get().saturating_sub(1));
            done(1);
            good(&vary(x))
        };
        let found = StabilityLimit::search((present, none), (from, to, BISECTIONS), value, good);
        done(left.get());
        found
    };
    let later = |ms: f64| Variation::later(1e-3 * ms);
    let stronger = |growth: f64| Variation::stronger(1.0 + growth);
    let (delay, gain) = rayon::join(
        || search(present_ms, (0.5, LONGEST_MS), &|ms| present_ms + ms, &later),
        || search(1.0, (0.02, LARGEST_GROWTH), &|x| 1.0 + x, &stronger),
    );
    Ok(CoupledMargins { delay, gain })
}
