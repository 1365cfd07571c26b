//! A channel's answer with its decision.

use super::channel::ChannelDiagnosis;
use super::decision::{Beside, Confirmed, Forbids, decide};
use crate::criteria::FALSE_SWINGS;
use crate::engine::Said;
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, FoundEffect, Line, Verdict};
use crate::model::interval;
use crate::prepare::advice::four;
use crate::prepare::hunting::{OwnSwing, own_swing};
use crate::prepare::input::{self, Deficiency};
use crate::prepare::{advice, wear};
use crate::record::recording::Recording;
use plant::{Channel, Effect};

/// Share of a residual's squares from which on a swing is most of it.
const MOST_OF_IT: f64 = 0.5;
/// Names of a loop that is slower than declared.
const SLOWER: [Effect; 3] = [Effect::LagError, Effect::DelayError, Effect::SecondLag];

/// What a loop that swings lacks.
fn oil_column(own: OwnSwing) -> FoundEffect {
    let about = [own.hz - own.bin_hz, own.hz + own.bin_hz];
    let frequency = ("frequency_hz", "Hz", own.hz, about);
    FoundEffect {
        q: Some(FALSE_SWINGS),
        ..FoundEffect::new(Effect::OilColumn, [frequency])
    }
}

fn hunts(own: OwnSwing) -> String {
    format!(
        "Once it moves, the ram swings by itself at {} Hz, {} mm rms; neither the command nor the rig at rest does. A position loop hunts \
         so if its oil is soft for its gain: air, long hoses, a gain that is too high. It is not in the improved model, and what else is \
         missing can be told once it is mended.",
        four(own.hz),
        four(own.rms_mm)
    )
}

/// An answer that is decided, and what describing it takes.
pub struct Heard {
    /// The answer.
    pub answer: ChannelAnswer,
    /// Its verdict if the motion could tell all names apart.
    pub found: Verdict,
    /// Lines that the motion does not have, if they forbid `none`.
    pub lines: Vec<Line>,
    /// The model with what was found.
    pub model: Model,
    /// The training and held-out records with their corners marked as not measured, if it was decided without them.
    pub smooth: Option<[Vec<Recording>; 2]>,
}

impl Heard {
    /// An answer as it is, with its model.
    pub fn unchanged(answer: ChannelAnswer, model: Model) -> Self {
        Self {
            found: answer.verdict,
            answer,
            lines: Vec::new(),
            model,
            smooth: None,
        }
    }
}

impl ChannelDiagnosis<'_> {
    /// Decides on what is proposed, and writes the decision beside the figures of an answer. `model`: what is proposed, if held-out
    /// data confirm it; `steps`: the converter's, if the training data have nothing else; the models: as declared, and with
    /// what is proposed.
    pub(super) fn heard<F>(
        &self,
        mut answer: ChannelAnswer,
        proposed: Option<&Said<F>>,
        model: Option<Confirmed>,
        steps: Option<FoundEffect>,
        [declared, with]: [&Model; 2],
    ) -> Heard {
        let nothing = proposed.is_none() && steps.is_none() && self.hum.is_none();
        let own = proposed.and_then(|said| self.own_swing(&answer.residuals[0], said));
        let hum = self.hum.as_ref().map(|h| h.effect.clone());
        let swing = hum.or_else(|| own.map(oil_column));
        let beside = Beside {
            steps,
            forbids_none: if nothing {
                self.forbids_none(&answer)
            } else {
                None
            },
            rail: &|| self.rail(&answer.unit),
            swing,
            lacks: &|effects| self.lacks(effects),
        };
        let decision = decide(proposed, model, beside);
        if let Some(why) = decision.forbids_names {
            return Heard::unchanged(self.not_assessed(why), declared.clone());
        }
        answer.verdict = decision.verdict;
        answer.ordinary &= decision.verdict == Verdict::None;
        answer.effects = decision.effects;
        answer.alternatives = decision.alternatives;
        answer.members = decision.members;
        if let Some(hum) = &self.hum {
            answer.error_before = hum.with.error_before;
            let [before, after] = [&hum.with.residuals[1], &answer.residuals[1]];
            let h = self.test[0].interval_s();
            answer.improvement_ci90 = interval::improvement(before, after, h);
            let measured = &hum.with.traces.measured;
            answer.traces.measured.clone_from(measured);
        }
        let mut lines = Vec::new();
        answer.notes = match decision.forbids_none {
            Some(Forbids {
                reason,
                lines: found,
                noise_share,
            }) => {
                answer.noise_floor_rms *= noise_share.sqrt();
                answer.disturbed = !found.is_empty() && !self.hunts(&self.test[0]);
                lines = found;
                vec![reason]
            }
            None => advice::engine(&answer, decision.found),
        };
        answer.notes.extend(decision.lacks);
        answer.notes.extend(own.map(hunts));
        Heard {
            found: decision.found,
            lines,
            ..Heard::unchanged(answer, with.clone())
        }
    }

    /// What the loop of an actuator swings by itself beside what is proposed: if that is all that is left, or beside a loop that is
    /// slower than declared, as one is that swings.
    fn own_swing<F>(&self, left: &[Vec<f64>], said: &Said<F>) -> Option<OwnSwing> {
        if self.base.channel != Channel::Actuator || self.hum.is_some() {
            return None;
        }
        let both = self.train.iter().zip(left);
        let (longest, left) = both.max_by_key(|(r, _)| r.time_s.len())?;
        let own = own_swing(longest, left)?;
        let slower = |names: &[Effect]| {
            let of_time = |n: &Effect| SLOWER.contains(n);
            names.iter().any(of_time) && !names.contains(&Effect::OilColumn)
        };
        match said {
            Said::Unknown(_) => own.share > MOST_OF_IT,
            Said::Names(named) => slower(&named.model.names),
            Said::Set(..) | Said::Nothing => false,
        }
        .then_some(own)
    }

    /// What the training motion lacks to tell these effects from others.
    fn lacks(&self, effects: &[FoundEffect]) -> Vec<Deficiency> {
        let channel = self.base.channel;
        let mut lacks = input::deficiencies(&self.base, self.train);
        lacks.extend(input::damages(channel, effects, self.train));
        lacks.extend(wear::deficiency(channel, effects, self.train));
        lacks
    }
}
