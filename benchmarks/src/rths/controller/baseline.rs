//! The published controller: PI with phase lead.

use super::interface::{Controller, ControllerInput, DeclaredPlant};
use crate::linear::Section;
use crate::rths::size::RATE_HZ;

/// `2 + 95 / s` on the error, with the target led by `50.8 (s + 168.6) / (s + 8570)`.
struct Baseline {
    lead: Section,
    /// Integral of the error, times 95/s, m.
    integral_m: f64,
}

pub(super) fn make(_: &DeclaredPlant) -> Box<dyn Controller> {
    Box::new(Baseline {
        lead: Section::new([50.8, 50.8 * 168.6], [1.0, 8570.0], 1.0 / RATE_HZ),
        integral_m: 0.0,
    })
}

impl Controller for Baseline {
    fn command_m(&mut self, seen: &ControllerInput) -> f64 {
        let error_m = self.lead.step(seen.floors_m[0]) - seen.displacement_m;
        let command_m = 2.0 * error_m + self.integral_m;
        // The error is held until the next sample, so its integral is exactly this sum.
        self.integral_m += 95.0 / RATE_HZ * error_m;
        command_m
    }
}
