//! Growth and damping of a loop's small motions, read from a run of it.
//!
//! | loop | growth |
//! |---|---|
//! | force as measured, fixed predictor: linear | its fastest growing motion's, by the [matrix pencil](super::pencil) |
//! | variable damping, corrected force, a predictor that learns | that of the rms between the window's halves |
//!
//! For several floors it is the largest over the coordinates of the structure's modes and over the actuators' commands:
//! what grows from sample to sample shows first in the commands.

use super::pencil::{Component, components};
use super::small_motion::{FreeMotion, Learning};
use super::structure_modes::StructureModes;
use super::variation::Variation;
use crate::failure::Failure;
use nalgebra::{Complex, DVector};
use outerloop_core::{Config, Force, Method};
use plant::RigSpec;
use schemars::JsonSchema;
use serde::Serialize;
use std::f64::consts::TAU;

/// A test whose small motions are to be found.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// The loop.
    pub config: &'a Config,
    /// The rig.
    pub rig: &'a RigSpec,
    /// Largest displacement of the planned motion, m.
    pub planned_peak_m: f64,
    /// What an adaptive predictor does in them.
    pub learning: Learning,
}

/// The small motions of a test under one compensation.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct SmallMotions {
    /// Its name.
    pub compensation: &'static str,
    /// True if all of them decay.
    pub stable: bool,
    /// True if larger motions do what small ones do: nothing in the loop but its specimen is nonlinear.
    pub decides: bool,
    /// What the fastest growing one grows by, 1/s of model time; negative: all decay; infinite (null in JSON): it was stopped
    /// before its growth could be read.
    pub growth_per_s: f64,
    /// Damping ratio of the first mode in the loop; NaN (null in JSON) where it is not among the motions.
    pub damping_ratio: f64,
    /// The structure's modes in the loop.
    #[serde(skip)]
    pub modes: Vec<LoopMode>,
}

impl SmallMotions {
    /// Their outcome, in tables.
    pub const fn word(&self) -> &'static str {
        match (self.stable, self.decides) {
            (true, true) => "decays",
            (true, false) => "not decided",
            (false, _) => "grows",
        }
    }
}

/// A mode of the closed loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
pub struct LoopMode {
    /// Natural frequency that the structure has, Hz of model time.
    pub structure_hz: f64,
    /// Frequency in the loop, Hz of model time.
    pub frequency_hz: f64,
    /// Damping ratio in the loop; negative: it grows.
    pub damping_ratio: f64,
}

/// True if a method's large motions behave like its small ones.
pub fn is_linear(method: Method) -> bool {
    method.force == Force::None && !method.predictor.learns()
}

/// Duration and resolution of the observation of a loop.
#[derive(Clone, Copy, Debug)]
struct Look {
    /// Periods of the first mode until the blow's transient has decayed, and learning has finished.
    settle: f64,
    /// Periods observed.
    window: f64,
    /// Growth is taken from the components, not from the rms.
    by_pencil: bool,
    /// Fraction of the motion that may not be exponential.
    resolution: f64,
    /// Growth that counts as none, as a fraction of the first natural frequency.
    none: f64,
}

/// A linear loop: the pencil's resolution is limited by f32 rounding.
const LINEAR: Look = Look {
    settle: 1.0,
    window: 4.0,
    by_pencil: true,
    resolution: 3e-6,
    none: 1e-5,
};
/// Variable damping and corrected forces act anew in every half period.
const DAMPED: Look = Look {
    settle: 2.0,
    window: 6.0,
    by_pencil: false,
    resolution: 1e-2,
    none: 1e-4,
};
/// Learning has to finish first.
const LEARNING: Look = Look {
    settle: 12.0,
    resolution: 1e-3,
    ..DAMPED
};
/// Number of samples used: enough to resolve the highest mode of eight floors over four periods of the first.
const SAMPLES: usize = 160;
/// Smallest component of a linear loop's motion that counts, as a fraction of the largest.
const LEAST_SHARE: f64 = 3e-4;
/// A signal below this fraction of the largest is a residue of the others.
const LEAST_SIGNAL: f64 = 1e-2;

impl Question<'_> {
    fn look(&self) -> Look {
        let method = self.config.compensation.kind;
        if method.predictor.learns() && self.learning == Learning::On {
            LEARNING
        } else if method.force != Force::None {
            DAMPED
        } else {
            LINEAR
        }
    }

    /// Response to a blow on the rig with `vary`.
    ///
    /// # Errors
    /// A test or a rig that cannot be run.
    pub fn small_motions(
        &self,
        structure: &StructureModes,
        vary: &Variation,
    ) -> Result<SmallMotions, Failure> {
        let look = self.look();
        let motion = self.free_motion(structure, vary)?;
        let seen = Seen::new(&motion, structure, look, self.config.physical_storeys());
        let growth_per_s = match seen.growth_per_s() {
            growth if motion.grown && (growth.is_nan() || growth <= 0.0) => f64::INFINITY,
            growth => growth,
        };
        let modes = seen.modes(structure);
        let first_hz = structure.omega[0] / TAU;
        let first = modes.iter().find(|m| m.structure_hz == first_hz);
        Ok(SmallMotions {
            compensation: self.config.compensation.kind.name(),
            stable: growth_per_s <= look.none * structure.omega[0],
            decides: is_linear(self.config.compensation.kind),
            growth_per_s,
            damping_ratio: first.map_or(f64::NAN, |m| m.damping_ratio),
            modes,
        })
    }

    /// Delay of the measured displacement behind the target in the first mode, s of the laboratory: what the predictor
    /// leaves of the rig's delay. `None` if the first mode is not among the motions.
    ///
    /// # Errors
    /// A test or a rig that cannot be run.
    pub fn remaining_lateness_s(&self, structure: &StructureModes) -> Result<Option<f64>, Failure> {
        let motion = self.free_motion(structure, &Variation::NONE)?;
        let seen = Seen::new(&motion, structure, self.look(), 0);
        let read = seen.along(&motion.read_m, &structure.coordinates[0]);
        let first = |all: &[Component]| nearest(all, structure.omega[0]);
        let of_target = seen.modes.first().and_then(|all| first(all));
        let both = of_target.zip(first(&seen.components(&read)));
        Ok(both.map(|(target, read)| {
            let model_s = (target.at_end / read.at_end).arg() / target.rate.im;
            model_s * self.config.timing.time_scale
        }))
    }

    fn free_motion(
        &self,
        structure: &StructureModes,
        vary: &Variation,
    ) -> Result<FreeMotion, Failure> {
        let mut config = self.config.clone();
        let damping = &mut config.structure.damping_ratio;
        damping.iter_mut().for_each(|ratio| *ratio *= vary.damping);
        let rig = vary.of(self.rig, &config);
        let look = self.look();
        let seconds = (look.settle + look.window) * TAU / structure.omega[0];
        FreeMotion::of(
            &config,
            &rig,
            structure,
            (self.planned_peak_m, self.learning),
            seconds,
        )
    }
}

/// The observed part of a motion.
struct Seen {
    look: Look,
    floors: usize,
    /// Number of samples of the motion, index of the first one used, and the distance between those used.
    whole: usize,
    from: usize,
    every: usize,
    interval_s: f64,
    /// The coordinate of each mode.
    coordinates: Vec<Vec<f64>>,
    /// The command of each actuator.
    commands: Vec<Vec<f64>>,
    /// The components of each coordinate.
    modes: Vec<Vec<Component>>,
}

impl Seen {
    fn new(motion: &FreeMotion, structure: &StructureModes, look: Look, actuators: usize) -> Self {
        let floors = structure.omega.len();
        let whole = motion.target_m.len() / floors;
        let wanted = (look.window * TAU / structure.omega[0] / motion.step_s) as usize;
        // If the motion was stopped early, everything that there is.
        let window = wanted.min(whole);
        let every = (window / SAMPLES).max(1);
        let mut seen = Self {
            look,
            floors,
            whole,
            // Includes the last sample.
            from: (whole - window) + window.saturating_sub(1) % every,
            every,
            interval_s: every as f64 * motion.step_s,
            coordinates: Vec::new(),
            commands: Vec::new(),
            modes: Vec::new(),
        };
        let rows = structure.coordinates.iter();
        seen.coordinates = rows.map(|row| seen.along(&motion.target_m, row)).collect();
        let axis = |axis| DVector::from_fn(floors, |j, _| f64::from(u8::from(j == axis)));
        seen.commands = (0..actuators)
            .map(|j| seen.along(&motion.sent_m, &axis(j)))
            .collect();
        let coordinates = seen.coordinates.iter();
        seen.modes = coordinates.map(|x| seen.components(x)).collect();
        seen
    }

    /// The samples of all floors, projected on `row`.
    fn along(&self, of: &[f64], row: &DVector<f64>) -> Vec<f64> {
        let sample = |k: usize| {
            (0..self.floors)
                .map(|j| row[j] * of[k * self.floors + j])
                .sum()
        };
        (self.from..self.whole)
            .step_by(self.every)
            .map(sample)
            .collect()
    }

    fn components(&self, samples: &[f64]) -> Vec<Component> {
        components(samples, self.interval_s, self.look.resolution)
    }

    fn growth_per_s(&self) -> f64 {
        let growths: Vec<f64> = if self.look.by_pencil {
            let fastest = |all: &Vec<Component>| {
                let largest = all.iter().map(|c| c.at_end.norm()).fold(0.0, f64::max);
                let counts = |c: &&Component| c.at_end.norm() > LEAST_SHARE * largest;
                let growths = all.iter().filter(counts).map(|c| c.rate.re);
                growths.fold(f64::NEG_INFINITY, f64::max)
            };
            let commands: Vec<_> = self.commands.iter().map(|x| self.components(x)).collect();
            self.modes.iter().chain(&commands).map(fastest).collect()
        } else {
            let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
            let halves = |x: &Vec<f64>| {
                let (first, second) = x.split_at(x.len() / 2);
                [rms(first), rms(second)]
            };
            let signals = self.coordinates.iter().chain(&self.commands);
            let all: Vec<[f64; 2]> = signals.map(halves).collect();
            let largest = all.iter().map(|h| h[1]).fold(0.0, f64::max);
            let apart_s =
                0.5 * (self.whole - self.from) as f64 / self.every as f64 * self.interval_s;
            let counts = |h: &&[f64; 2]| h[0] > 0.0 && h[1] > LEAST_SIGNAL * largest;
            let growth = |h: &[f64; 2]| (h[1] / h[0]).ln() / apart_s;
            all.iter().filter(counts).map(growth).collect()
        };
        growths.into_iter().fold(f64::NEG_INFINITY, f64::max)
    }

    /// The structure's modes in the loop: in each one's coordinate, the nearest component.
    fn modes(&self, structure: &StructureModes) -> Vec<LoopMode> {
        let omegas = structure.omega.iter().zip(&self.modes);
        omegas
            .filter_map(|(&omega, all)| {
                let s = nearest(all, omega)?.rate;
                Some(LoopMode {
                    structure_hz: omega / TAU,
                    frequency_hz: s.norm() / TAU,
                    damping_ratio: -s.re / s.norm(),
                })
            })
            .collect()
    }
}

/// The component nearest to a mode of `omega`, rad/s; further away than that it would be another motion.
fn nearest(all: &[Component], omega: f64) -> Option<Component> {
    let own = Complex::new(0.0, omega);
    let away = |c: &Component| (c.rate - own).norm();
    let near = all.iter().filter(|c| c.rate.im > 0.0 && away(c) < omega);
    near.min_by(|a, b| away(a).total_cmp(&away(b))).copied()
}
