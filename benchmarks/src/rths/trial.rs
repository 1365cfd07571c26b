//! A closed loop under a ground motion, and what it leaves.

use super::case::{Case, Structure};
use super::criteria::Criteria;
use super::transfer::{Channels, Parameters, Specimen, TransferSystem};
use super::{FLOORS, GROUND_SCALE, RATE_HZ};

/// What the loop gets to see at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Displacement of the specimen, m.
    pub displacement_m: f64,
    /// Force of the specimen, N.
    pub force_n: f64,
    /// Ground acceleration now and at the next sample, m/s^2.
    pub ground_m_per_s2: [f64; 2],
}

/// What the loop answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Where the numerical part has its floors at this sample, m; the first is the target.
    pub floors_m: [f64; FLOORS],
    /// Command until the next sample, m.
    pub command_m: f64,
}

/// A numerical part with a controller.
pub trait HybridLoop {
    /// One sampling period.
    fn step(&mut self, reading: &Reading) -> Answer;
}

/// A ground motion at the samples of the problem, scaled as the problem has it.
#[derive(Clone, Debug)]
pub struct Shaking {
    /// Acceleration, m/s^2.
    pub acc_m_per_s2: Vec<f64>,
}

impl Shaking {
    /// From points `interval_s` apart, m/s^2, by linear interpolation.
    pub fn new(points_m_per_s2: &[f64], interval_s: f64) -> Self {
        let end_s = points_m_per_s2.len().saturating_sub(1) as f64 * interval_s;
        let samples = (end_s * RATE_HZ).floor() as usize + 1;
        let at = |i: usize| points_m_per_s2.get(i).copied().unwrap_or(0.0);
        let acc_m_per_s2 = (0..samples)
            .map(|k| {
                let place = k as f64 / RATE_HZ / interval_s;
                let i = place.floor();
                let rise = at(i as usize + 1) - at(i as usize);
                GROUND_SCALE * (at(i as usize) + (place - i) * rise)
            })
            .collect();
        Self { acc_m_per_s2 }
    }

    /// The displacements of the whole structure of `case` at each sample: the reference.
    pub fn reference(&self, case: &Case) -> Vec<[f64; FLOORS]> {
        self.reference_with(case, &Specimen::NOMINAL)
    }

    /// The same with another specimen in the structure: what a perfect controller would measure with that specimen.
    pub fn reference_with(&self, case: &Case, specimen: &Specimen) -> Vec<[f64; FLOORS]> {
        let mut matrices = case.numerical();
        matrices.mass[(0, 0)] += specimen.mass_kg;
        matrices.damping[(0, 0)] += specimen.damping_n_s_per_m;
        matrices.stiffness[(0, 0)] += specimen.stiffness_n_per_m;
        let Some(mut structure) = Structure::new(case, &matrices) else {
            return Vec::new();
        };
        self.pairs()
            .map(|ground| {
                let floors = structure.floors_m();
                structure.step(ground, 0.0);
                floors
            })
            .collect()
    }

    /// The acceleration of each sample with the next one's.
    fn pairs(&self) -> impl Iterator<Item = [f64; 2]> {
        let next = self.acc_m_per_s2.iter().skip(1).chain([&0.0]);
        self.acc_m_per_s2.iter().zip(next).map(|(a, b)| [*a, *b])
    }
}

/// What a trial leaves, a value a sample.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// Target of the specimen, m.
    pub target_m: Vec<f64>,
    /// Displacement as it was read, m.
    pub measured_m: Vec<f64>,
    /// Displacement as it was, without noise, m.
    pub moved_m: Vec<f64>,
    /// Floors of the numerical part, m.
    pub floors_m: Vec<[f64; FLOORS]>,
    /// What the specimen really did.
    pub demand: Demand,
}

/// The largest of what the rig is limited in.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    /// Displacement, m.
    pub displacement_m: f64,
    /// Velocity, m/s.
    pub velocity_m_per_s: f64,
    /// Force, N.
    pub force_n: f64,
}

impl Demand {
    /// What the rig can: 7 mm, 300 mm/s, 8900 N.
    pub const LIMITS: Self = Self {
        displacement_m: 7e-3,
        velocity_m_per_s: 0.3,
        force_n: 8900.0,
    };

    /// Whether the rig could have done it.
    pub fn within_limits(&self) -> bool {
        let l = &Self::LIMITS;
        self.displacement_m <= l.displacement_m
            && self.velocity_m_per_s <= l.velocity_m_per_s
            && self.force_n <= l.force_n
    }

    fn see(&mut self, plant: &TransferSystem) {
        let [x, v, _] = plant.motion();
        // A NaN becomes infinite: no limit holds it.
        let larger = |a: f64, b: f64| {
            if b.is_nan() {
                f64::INFINITY
            } else {
                a.max(b.abs())
            }
        };
        self.displacement_m = larger(self.displacement_m, x);
        self.velocity_m_per_s = larger(self.velocity_m_per_s, v);
        self.force_n = larger(self.force_n, plant.force_n());
    }
}

/// The loop on the rig under the ground motion, from rest; `seed` is that of the sensors' noise.
pub fn run(
    hybrid: &mut impl HybridLoop,
    plant: &Parameters,
    shaking: &Shaking,
    seed: u64,
) -> Trace {
    let mut plant = TransferSystem::new(plant);
    let mut channels = Channels::new(seed);
    let mut trace = Trace::default();
    for ground_m_per_s2 in shaking.pairs() {
        let (displacement_m, force_n) = channels.read(plant.motion()[0], plant.force_n());
        let answer = hybrid.step(&Reading {
            displacement_m,
            force_n,
            ground_m_per_s2,
        });
        trace.target_m.push(answer.floors_m[0]);
        trace.measured_m.push(displacement_m);
        trace.moved_m.push(plant.motion()[0]);
        trace.floors_m.push(answer.floors_m);
        trace.demand.see(&plant);
        plant.step(channels.send(answer.command_m));
    }
    trace
}

/// A trial and its verdict.
pub fn judge(
    hybrid: &mut impl HybridLoop,
    plant: &Parameters,
    shaking: &Shaking,
    reference: &[[f64; FLOORS]],
    seed: u64,
) -> (Criteria, Trace) {
    let trace = run(hybrid, plant, shaking, seed);
    (Criteria::of(&trace, reference), trace)
}
