//! The fixed inverse of the declared plant to third order: `A_0 r + A_1 r' + A_2 r'' + A_3 r'''` over the numerator, with
//! backward differences of the target.

use super::interface::{Controller, ControllerInput, DeclaredPlant};
use crate::rths::size::RATE_HZ;

struct FixedInverse {
    /// Factors of the target and its first three differences.
    factors: [f64; 4],
    /// The target and its first two differences one sample ago, m.
    last_m: [f64; 3],
}

pub(super) fn make(declared: &DeclaredPlant) -> Box<dyn Controller> {
    let [a0, a1, a2, a3, ..] = declared.plant.inverse();
    Box::new(FixedInverse {
        factors: [a0, a1 * RATE_HZ, a2 * RATE_HZ.powi(2), a3 * RATE_HZ.powi(3)],
        last_m: [0.0; 3],
    })
}

impl Controller for FixedInverse {
    fn command_m(&mut self, seen: &ControllerInput) -> f64 {
        let r = seen.floors_m[0];
        let first = r - self.last_m[0];
        let second = first - self.last_m[1];
        let third = second - self.last_m[2];
        self.last_m = [r, first, second];
        let [a0, a1, a2, a3] = self.factors;
        a0 * r + a1 * first + a2 * second + a3 * third
    }
}
