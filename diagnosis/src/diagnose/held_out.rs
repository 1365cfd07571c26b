//! The judgement of held-out data: on a proposed model, and on `none`. It decides nothing (see `decision`).

use super::by_engine::{ChannelData, Left};
use super::channel::ChannelDiagnosis;
use super::decision::Forbids;
use crate::criteria::{
    ACCOUNTS, BESIDE_NOISE, DISPLACEMENT_TRANSDUCER, MOST_OF_IT, NOISE, SET_LEAVES, TRANSDUCER,
    WORTH_A_NAME,
};
use crate::engine::{self, Asked, Said};
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Errors, Nearest};
use crate::model::interval;
use crate::numbers::signals::rms;
use crate::prepare::advice::four;
use crate::record::recording::Recording;
use crate::record::rest;
use plant::{Channel, Effect};

/// A proposed model on training and held-out records.
pub struct Tried<F> {
    /// Its fit.
    pub fit: F,
    /// Its residuals.
    pub left: Left,
    /// Their size.
    pub errors: Errors,
    /// 90 % interval of the decrease of the held-out rms.
    pub gain: [f64; 2],
    /// The held-out data confirm it.
    pub confirmed: bool,
    /// It accounts for the training data.
    pub accounts: bool,
    /// The credible fraction of its names' probabilities.
    pub trust: f64,
}

impl ChannelDiagnosis<'_> {
    /// Tries the model of what is proposed; `None` if there is none. `before`: what the declared model leaves, refitted.
    pub(super) fn tried<A: Asked>(
        &self,
        channel: &ChannelData<A>,
        proposed: &Said<A::Fit>,
        before: &Left,
    ) -> Option<Tried<A::Fit>> {
        let candidate = proposed.model()?;
        let fit = channel.data.settled(&candidate.model);
        let left = channel.left(&fit)?;
        let errors = self.errors_left(&left);
        let gain = interval::improvement(&before[1], &left[1], self.train[0].interval_s());
        // A model that does not reach the noise must explain most: a law not in the table may be the cause.
        let most = if candidate.evidence.left_rms() < 1.0 {
            1.0 - WORTH_A_NAME
        } else {
            SET_LEAVES
        };
        // Without the noise, if a rest determines it.
        let noise = if channel.told { channel.noise.rms } else { 0.0 };
        let beyond = |rms: f64| (rms * rms - noise * noise).max(0.0).sqrt();
        let refitted = self.errors_left(before).test_rms;
        let had = beyond(self.without_refit_of(&candidate.names, refitted));
        let has = beyond(errors.test_rms);
        // Held-out data that have died down to the noise are evidence neither way.
        let better = has <= most * had && (gain[0] > 0.0 || matches!(proposed, Said::Set(..)));
        let confirmed = had.max(has) == 0.0 || better;
        let floor = channel.noise.rms.min(refitted).min(errors.test_rms);
        Some(Tried {
            confirmed: confirmed && !matches!(proposed, Said::Unknown(_)),
            accounts: self.accounts(before, &left, floor, channel.told),
            trust: engine::trust(&candidate.evidence),
            fit,
            left,
            errors,
            gain,
        })
    }

    /// True if a model leaves the training data a small part of their residual while they move, or noise.
    fn accounts(&self, before: &Left, left: &Left, noise: f64, told: bool) -> bool {
        let share = ACCOUNTS * while_moving(&before[0], self.train);
        let known = if told { BESIDE_NOISE } else { f64::INFINITY };
        let most = share.min(known * noise).max(NOISE * noise);
        while_moving(&left[0], self.train) <= most
    }

    /// Held-out rms error, the baseline for a model of these names. If one of them is an error of a declared parameter,
    /// the refit within the tolerances has already taken part of it, so the declared model counts.
    fn without_refit_of(&self, names: &[Effect], refitted: f64) -> f64 {
        let parameters = self.base.channel.parameters();
        let is_error = |name: &Effect| parameters.iter().any(|p| p.error == *name);
        let declared = names.iter().any(is_error).then(|| self.declared_leaves());
        declared.flatten().map_or(refitted, |d| d.max(refitted))
    }

    /// The model that comes nearest, which is not confirmed, and the fraction of the held-out squares that it explains.
    pub(super) fn nearest<A: Asked>(
        &self,
        name: Effect,
        data: &A,
        tried: &Tried<A::Fit>,
        before: &Left,
        model: &Model,
    ) -> Nearest {
        let share = rms(&tried.left[1]) / rms(&before[1]).max(f64::MIN_POSITIVE);
        let mut model = model.bare(self.base.channel);
        data.save(&tried.fit, &mut model);
        // Do not save an inadmissible model: a saved file must be readable again.
        let own = model.channel(self.base.channel);
        let own = own.filter(|_| model.check().is_ok());
        Nearest {
            name,
            explained: (1.0 - share * share).clamp(0.0, 1.0),
            effects: own.as_ref().map_or(Vec::new(), |c| c.effects.to_vec()),
            elements: own.as_ref().map_or(Vec::new(), |c| c.elements.to_vec()),
        }
    }

    /// Why `none` cannot be said of a channel whose training data have nothing: the held-out data leave more than noise, so something
    /// acts there that the training data do not show; the residual is most of the output; or it is lines that the motion does not have.
    pub(super) fn forbids_none(&self, answer: &ChannelAnswer) -> Option<Forbids> {
        let (left, noise) = (answer.error_before.test_rms, answer.noise_floor_rms);
        let class = match self.base.channel {
            // An ordinary ram leaves the same fraction of any motion.
            Channel::Actuator if answer.ordinary => BESIDE_NOISE * answer.error_before.train_nrmse,
            Channel::Actuator => self.base.ordinary().max(DISPLACEMENT_TRANSDUCER),
            Channel::Specimen => TRANSDUCER,
        };
        let unit = &answer.unit;
        let within = left <= BESIDE_NOISE * noise || answer.error_before.test_nrmse < class;
        let errors = &answer.error_before;
        let share = errors.test_nrmse.max(errors.train_nrmse);
        let reason = if !left.is_finite() {
            return None;
        } else if !within {
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
            return self.lines_in_place_of_noise(answer);
        };
        Some(Forbids {
            reason,
            lines: Vec::new(),
            noise_share: 1.0,
        })
    }
}

/// Rms residual while the records move: at rest friction holds any force.
fn while_moving(left: &[Vec<f64>], records: &[Recording]) -> f64 {
    let moving = |(r, left): (&Recording, &Vec<f64>)| {
        let skipped = r.time_s.len() - left.len();
        let part = rest::moving(r);
        left[part.start.saturating_sub(skipped)..part.end.saturating_sub(skipped)].to_vec()
    };
    rms(&records.iter().zip(left).map(moving).collect::<Vec<_>>())
}
