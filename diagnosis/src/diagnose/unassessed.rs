//! Channels without a verdict.

use super::channel::ChannelDiagnosis;
use crate::model::answer::{ChannelAnswer, Errors, Verdict};
use crate::prepare::fit::settle;
use crate::prepare::noise::Noise;
use crate::prepare::problem::Problem;

impl ChannelDiagnosis<'_> {
    /// An answer without figures, with the reason.
    pub(super) fn not_assessed(&self, why: impl Into<String>) -> ChannelAnswer {
        let mut answer = self.blank(Verdict::NotAssessed);
        let unknown = Errors::UNKNOWN;
        (
            answer.error_declared,
            answer.error_before,
            answer.error_after,
        ) = (unknown, unknown, unknown);
        (answer.noise_floor_rms, answer.improvement_ci90) = (f64::NAN, [f64::NAN; 2]);
        answer.notes.push(why.into());
        answer
    }

    /// Errors without a verdict, if the noise cannot be determined.
    pub(super) fn errors_without_verdict(
        &self,
        problem: &Problem,
        cutoff_hz: f64,
    ) -> ChannelAnswer {
        let mut answer = self.not_assessed(
            "the record is too short to tell its noise, so no residual can be called significant; record longer, with a \
             second of rest",
        );
        let still = Noise::at_rest(
            &[vec![1.0, -1.0, 1.0, -1.0]],
            problem.scales.interval_s,
            1.0,
        );
        if let Some(s) = settle(problem, &self.base, &still) {
            answer.error_before = self.errors(&s, cutoff_hz).0;
            answer.error_after = answer.error_before;
        }
        answer
    }
}
