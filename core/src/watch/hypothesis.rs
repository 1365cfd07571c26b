//! The single cause that explains a window best, and whether it stands out enough for a name.

use super::regression::Answer;

/// Twice the logarithm of the likelihood ratio from which there is a name: of the actuator, of the force, of the unloading.
const NAME: [f32; 3] = [12.0, 12.0, 48.0];
/// By how many standard deviations a value is beyond its tolerance of two halves.
const BEYOND: [f32; 3] = [2.0, 2.0, 5.0];
/// Share of the residual that the free fit has to explain.
const EXPLAINED: f32 = 0.7;

/// The best single cause of a regression in a window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hypothesis {
    pub(super) d: f32,
    pub(super) column: usize,
    pub(super) answer: Answer,
}

impl Hypothesis {
    /// True if it stands out enough for a name.
    pub(super) fn is_name(&self, regression: usize) -> bool {
        let (theta, sd) = (self.answer.theta[self.column], self.answer.sd[self.column]);
        self.d > NAME[regression]
            && theta.abs() > 2.0 + BEYOND[regression] * sd
            && self.answer.explained > EXPLAINED
    }

    /// The columns that explain it about as well.
    pub(super) fn set(&self) -> impl Iterator<Item = usize> {
        let least = 0.92 * self.d - 6.0;
        let d = self.answer.d;
        (0..d.len()).filter(move |j| d[*j] > 0.0 && d[*j] > least)
    }
}
