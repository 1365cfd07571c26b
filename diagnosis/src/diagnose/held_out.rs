//! Held-out data with a larger residual than the training data.

use super::channel::ChannelDiagnosis;
use crate::criteria::{BESIDE_NOISE, DISPLACEMENT_TRANSDUCER, MOST_OF_IT, TRANSDUCER};
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::prepare::advice::four;
use plant::Channel;

impl ChannelDiagnosis<'_> {
    /// `none` holds if the residual is not most of the output, and if the held-out data leave no more than noise, too:
    /// otherwise something acts there that the training data do not show.
    pub(super) fn check_none_on_held_out(&self, answer: &mut ChannelAnswer) {
        let (left, noise) = (answer.error_before.test_rms, answer.noise_floor_rms);
        let class = match self.base.channel {
            // An ordinary ram leaves the same fraction of any motion.
            Channel::Actuator if answer.ordinary => BESIDE_NOISE * answer.error_before.train_nrmse,
            Channel::Actuator => self.base.ordinary().max(DISPLACEMENT_TRANSDUCER),
            Channel::Specimen => TRANSDUCER,
        };
        if answer.verdict != Verdict::None || !left.is_finite() {
            return;
        }
        let unit = &answer.unit;
        let within = left <= BESIDE_NOISE * noise || answer.error_before.test_nrmse < class;
        let errors = &answer.error_before;
        let share = errors.test_nrmse.max(errors.train_nrmse);
        let note = if !within {
            format!(
                "The training data leave nothing but a noise of {} {unit}, and the held-out data leave {} {unit} rms: something \
                 acts there that the training data do not show. Train with data that go as far and as fast.",
                four(noise),
                four(left)
            )
        } else if share > MOST_OF_IT {
            format!(
                "What is left ({} {unit} rms) is called noise, and it is {:.0} % of what the output moves by: such a noise hides whatever \
                 is missing. Record larger motions, or a rest that is one, and mend what makes that noise.",
                four(left),
                100.0 * share
            )
        } else {
            return;
        };
        answer.verdict = Verdict::Unknown;
        answer.notes = vec![note];
    }
}
