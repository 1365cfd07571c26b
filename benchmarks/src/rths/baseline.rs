//! The published controller: PI with phase lead, around a numerical part in f64.

use super::RATE_HZ;
use super::case::{Case, Structure};
use super::trial::{Answer, HybridLoop, Reading};
use crate::linear::Section;

/// `2 + 95 / s` on the error, the target led by `50.8 (s + 168.6) / (s + 8570)`.
#[derive(Clone, Debug)]
pub struct Baseline {
    structure: Structure,
    lead: Section,
    /// Integral of the error, times 95/s, m.
    integral_m: f64,
    /// The force is used a sample late.
    force_n: f64,
}

impl Baseline {
    /// Around the numerical part of `case`, at rest.
    ///
    /// Returns `None` for a mass matrix that is not positive definite.
    pub fn new(case: &Case) -> Option<Self> {
        let period_s = 1.0 / RATE_HZ;
        Some(Self {
            structure: Structure::new(case, &case.numerical())?,
            lead: Section::new([50.8, 50.8 * 168.6], [1.0, 8570.0], period_s),
            integral_m: 0.0,
            force_n: 0.0,
        })
    }
}

impl HybridLoop for Baseline {
    fn step(&mut self, reading: &Reading) -> Answer {
        let floors_m = self.structure.floors_m();
        let error_m = self.lead.step(floors_m[0]) - reading.displacement_m;
        let command_m = 2.0 * error_m + self.integral_m;
        // The error is a reading: held until the next, its integral is exactly this sum.
        self.integral_m += 95.0 / RATE_HZ * error_m;
        self.structure.step(reading.ground_m_per_s2, self.force_n);
        self.force_n = reading.force_n;
        Answer {
            floors_m,
            command_m,
        }
    }
}
