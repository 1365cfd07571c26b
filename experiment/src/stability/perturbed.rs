//! The worst of many rigs.

use super::growth::Question;
use super::structure_modes::StructureModes;
use super::variation::Variation;
use crate::failure::Failure;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;

/// How rigs differ from the declared one: standard deviations, as fractions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    /// Number of rigs.
    pub plants: usize,
    /// Seed of the draw.
    pub seed: u64,
    /// Of the actuator's times.
    pub delay: f64,
    /// Of its gain.
    pub gain: f64,
    /// Of the specimen's stiffness.
    pub stiffness: f64,
    /// Of the structure's damping; with two coupled actuators of the specimen's.
    pub damping: f64,
}

/// What was found on them.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Perturbed {
    /// How they were drawn.
    pub spread: Spread,
    /// On how many of them a small motion grows.
    pub unstable: usize,
    /// Fastest growth of a small motion, 1/s of model time.
    pub worst_growth_per_s: f64,
    /// Smallest damping ratio of the first mode.
    pub least_damping_ratio: f64,
    /// The rig with the fastest growth.
    pub worst: Option<Variation>,
    /// Growth of each, ascending.
    #[serde(skip)]
    pub growths_per_s: Vec<f64>,
}

/// Largest deviation of a rig, in standard deviations.
const FURTHEST: f64 = 3.0;

impl Spread {
    /// Draws the rigs.
    pub fn draw(&self) -> Vec<Variation> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let mut factor = |deviation: f64| {
            let normal: f64 = StandardNormal.sample(&mut random);
            (1.0 + deviation * normal.clamp(-FURTHEST, FURTHEST)).max(0.0)
        };
        (0..self.plants)
            .map(|_| Variation {
                delay: factor(self.delay),
                extra_s: 0.0,
                gain: factor(self.gain),
                stiffness: factor(self.stiffness),
                damping: factor(self.damping),
            })
            .collect()
    }
}

/// Runs all rigs of `spread`, on all cores.
///
/// # Errors
/// A test that cannot be set up.
pub fn of(
    question: &Question<'_>,
    structure: &StructureModes,
    spread: &Spread,
    one_done: impl Fn() + Sync,
) -> Result<Perturbed, Failure> {
    let mut rows = spread
        .draw()
        .into_par_iter()
        .map(|vary| {
            let row = question.small_motions(structure, &vary);
            one_done();
            Ok((vary, row?))
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    rows.sort_by(|a, b| a.1.growth_per_s.total_cmp(&b.1.growth_per_s));
    let worst = rows.last();
    Ok(Perturbed {
        spread: *spread,
        unstable: rows.iter().filter(|(_, r)| !r.stable).count(),
        worst_growth_per_s: worst.map_or(f64::NAN, |(_, r)| r.growth_per_s),
        least_damping_ratio: rows
            .iter()
            .map(|(_, r)| r.damping_ratio)
            .fold(f64::INFINITY, f64::min),
        worst: worst.map(|(v, _)| *v),
        growths_per_s: rows.iter().map(|(_, r)| r.growth_per_s).collect(),
    })
}
