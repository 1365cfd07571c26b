//! The single cause that explains a window best, and whether it is clear enough to be named.

use super::regression::Answer;

/// Twice the log-likelihood ratio needed for a name: of the actuator, of the force, of the unloading.
const NAME: [f32; 3] = [12.0, 12.0, 48.0];
/// Standard deviations by which a value must exceed its tolerance of two halves.
const BEYOND: [f32; 3] = [2.0, 2.0, 5.0];
/// Fraction of the residual that the free fit must explain.
const EXPLAINED: f32 = 0.7;

/// For a change relative to values learnt in the same test: likelihood ratio, deviations of both, half tolerances.
const CHANGED: f32 = 12.0;
const CHANGED_DEVIATIONS: f32 = 3.5;
const CHANGED_BY: f32 = 3.5;

/// Columns of the actuator's regression that are limits: speed, stroke.
const LIMITS: [usize; 2] = [5, 6];

/// The best single cause of a regression in a window.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hypothesis {
    pub(super) d: f32,
    pub(super) column: usize,
    pub(super) answer: Answer,
}

impl Hypothesis {
    #[inline(never)] // It is called from many places.
    pub(super) fn of(answer: Answer) -> Self {
        let (column, d) = answer.best();
        Self { d, column, answer }
    }

    /// True if it qualifies as a doubt, and a limit of the actuator explains it about as well as anything else.
    pub(super) fn is_limit_in_doubt(&self, doubt: f32) -> bool {
        self.d > doubt && self.set().any(|column| LIMITS.contains(&column))
    }

    /// True if it is clear enough to be named.
    #[inline(never)] // As above.
    pub(super) fn is_name(&self, regression: usize) -> bool {
        let (theta, sd) = (self.answer.theta[self.column], self.answer.sd(self.column));
        self.d > NAME[regression]
            && theta.abs() > 2.0 + BEYOND[regression] * sd
            && self.answer.explained > EXPLAINED
    }

    /// True if its coefficient is further from zero than a learnt one, by enough to be a different one.
    #[inline(never)] // As above.
    pub(super) fn is_change_from(&self, [learnt, learnt_sd]: [f32; 2]) -> bool {
        let (theta, sd) = (self.answer.theta[self.column], self.answer.sd(self.column));
        let change = theta - learnt;
        self.d > CHANGED
            && theta.abs() > 2.0 + 2.0 * sd
            && change.abs() > CHANGED_BY
            && change.abs() > CHANGED_DEVIATIONS * libm::sqrtf(sd * sd + learnt_sd * learnt_sd)
            && change * theta > 0.0
            && self.answer.explained > EXPLAINED
    }

    /// The columns that explain the window about as well.
    pub(super) fn set(&self) -> impl Iterator<Item = usize> {
        let least = 0.92 * self.d - 6.0;
        let d = self.answer.ratios();
        (0..d.len()).filter(move |j| d[*j] > 0.0 && d[*j] > least)
    }
}

/// The least coefficient of a column that would be named given the noise of a window, half tolerances.
pub(super) fn least_named(answer: &Answer, regression: usize, column: usize) -> Option<f32> {
    let sd = answer.sd(column);
    let beyond = 2.0 + BEYOND[regression] * sd;
    let likely = libm::sqrtf(NAME[regression] * (sd * sd + 1.0));
    // Without freedom there is no deviation.
    (sd > 0.0).then(|| beyond.max(likely))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_in_doubt_where_it_explains_what_stands_out_about_as_well_as_the_best() {
        let in_doubt = |gain: f32, stroke: f32| {
            let mut answer = Answer::default();
            // With zero variance the ratio is the square of the coefficient.
            (answer.theta[1], answer.theta[6]) = (libm::sqrtf(gain), libm::sqrtf(stroke));
            Hypothesis::of(answer).is_limit_in_doubt(8.0)
        };
        assert!(in_doubt(100.0, 95.0), "gain fits best, a stroke nearly");
        assert!(in_doubt(0.0, 9.0), "no name yet");
        assert!(!in_doubt(100.0, 60.0), "a gain and nothing else");
        assert!(!in_doubt(5.0, 6.0), "nothing stands out");
    }
}
