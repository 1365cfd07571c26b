//! Held-out data that leave more than the training data.

use super::channel::ChannelDiagnosis;
use crate::advice::four;
use crate::answer::{ChannelAnswer, Verdict};
use crate::criteria::{BESIDE_NOISE, DISPLACEMENT_TRANSDUCER, TRANSDUCER};
use plant::Channel;

impl ChannelDiagnosis<'_> {
    /// `none` holds where the held-out data leave no more than noise, too: else something acts there that the training data do not
    /// show.
    pub(super) fn doubt_none(&self, answer: &mut ChannelAnswer) {
        let (left, noise) = (answer.error_before.test_rms, answer.noise_floor_rms);
        let class = match self.base.channel {
            Channel::Actuator => DISPLACEMENT_TRANSDUCER,
            Channel::Specimen => TRANSDUCER,
        };
        let within = left <= BESIDE_NOISE * noise || answer.error_before.test_nrmse < class;
        if answer.verdict != Verdict::None || within || !left.is_finite() {
            return;
        }
        answer.verdict = Verdict::Unknown;
        let (left, noise, unit) = (four(left), four(noise), &answer.unit);
        answer.notes = vec![format!(
            "The training data leave nothing but a noise of {noise} {unit}, and the held-out data leave {left} {unit} rms: something \
             acts there that the training data do not show. Train with data that go as far and as fast."
        )];
    }
}
