//! A ground motion of the problem, and trials under it.

use super::baseline::Baseline;
use super::case::{CASES, Case};
use super::controller::{Controller, compensation, tangent_behind};
use super::core_loop::CoreLoop;
use super::transfer::Parameters;
use super::trial::{self, Shaking, Trace};
use super::{FLOORS, GROUND_SCALE, RATE_HZ};
use crate::Refused;
use outerloop_core::config::Compensation;
use outerloop_core::{GroundMotion, Prediction, State};

/// A ground motion with the reference responses of all cases.
pub struct Record {
    /// Its name.
    pub name: String,
    shaking: Shaking,
    points: Vec<f32>,
    interval_s: f64,
    references: Vec<Vec<[f64; FLOORS]>>,
}

impl Record {
    /// From points `interval_s` apart, m/s^2; scales as the problem has it.
    pub fn new(name: &str, acc_m_per_s2: &[f32], interval_s: f64) -> Self {
        let points: Vec<f64> = acc_m_per_s2.iter().copied().map(f64::from).collect();
        let shaking = Shaking::new(&points, interval_s);
        Self {
            name: name.to_owned(),
            references: CASES.iter().map(|c| shaking.reference(c)).collect(),
            shaking,
            points: points.iter().map(|a| (a * GROUND_SCALE) as f32).collect(),
            interval_s,
        }
    }

    /// The reference response of `case`, m: the whole structure with the nominal specimen in it.
    pub fn reference(&self, case: &Case) -> &[[f64; FLOORS]] {
        let place = usize::from(case.number).saturating_sub(1);
        self.references.get(place).map_or(&[], |r| r)
    }

    /// The response of the structure of `case` with the specimen of `plant` in it, m.
    pub fn reference_with(&self, case: &Case, plant: &Parameters) -> Vec<[f64; FLOORS]> {
        self.shaking.reference_with(case, &plant.specimen)
    }

    /// Trial of `controller` on `plant`, with the sensors' noise of `draw`.
    ///
    /// # Errors
    /// A loop that core refuses.
    pub fn trial(
        &self,
        controller: &Controller,
        case: &Case,
        plant: &Parameters,
        draw: u64,
    ) -> Result<Trace, Refused> {
        let told = match controller {
            Controller::Baseline => {
                let mut baseline = Baseline::new(case)
                    .ok_or_else(|| Refused::new("rths: the numerical mass is not positive"))?;
                return Ok(trial::run(&mut baseline, plant, &self.shaking, draw));
            }
            Controller::Best => tangent_behind(case, Prediction::Ats),
            Controller::TangentInverse => tangent_behind(case, Prediction::FeedforwardFeedback),
            Controller::Method(method) => compensation(case, *method),
        };
        self.trial_of_core(&told, case, plant, draw)
    }

    /// Trial of core with any compensation. A loop that tripped leaves no numbers.
    ///
    /// # Errors
    /// A loop that core refuses.
    pub fn trial_of_core(
        &self,
        told: &Compensation,
        case: &Case,
        plant: &Parameters,
        draw: u64,
    ) -> Result<Trace, Refused> {
        let ground = GroundMotion::new(&self.points, self.interval_s, 1.0 / RATE_HZ)
            .ok_or_else(|| Refused::new(format!("{}: cannot be laid out", self.name)))?;
        let mut hybrid = CoreLoop::new(case, told, ground)?;
        let mut trace = trial::run(&mut hybrid, plant, &self.shaking, draw);
        if hybrid.state() == State::Tripped {
            trace.moved_m.fill(f64::NAN);
            trace.measured_m.fill(f64::NAN);
            trace.floors_m.fill([f64::NAN; FLOORS]);
        }
        Ok(trace)
    }
}
