//! Springs that are not straight, and what draws the same curve: a limit and a gap whose corners are round.

use super::channel::ChannelDiagnosis;
use crate::advice::four;
use crate::answer::{ChannelAnswer, Member, Verdict};
use crate::criteria::{CERTAIN, LEAST_TIMES, WEIGHT};
use crate::explain::best_alone;
use crate::library::{Candidate, ROUNDED_GAP, ROUNDED_LIMIT};
use plant::{Channel, Effect};

/// Which one draws the curve of a name, what it is called, and what tells the two apart.
fn rival(name: Effect) -> Option<(Candidate, &'static str, &'static str)> {
    match name {
        Effect::Softening => Some((
            ROUNDED_LIMIT,
            "A force that ends at a limit with a rounded corner",
            "A larger motion tells: a limit is not passed.",
        )),
        Effect::Hardening => Some((
            ROUNDED_GAP,
            "A gap with rounded corners",
            "A motion of a part of that gap tells: it meets hardly any force.",
        )),
        _ => None,
    }
}

impl ChannelDiagnosis<'_> {
    /// Makes a set of a spring that softens or stiffens and of a limit or a gap with rounded corners that leaves less than
    /// what a name alone has to rule out of the same held-out data.
    pub(super) fn add_rounded_rival(&self, answer: &mut ChannelAnswer) {
        let [one] = &answer.effects[..] else {
            return;
        };
        let Some((candidate, what, tells)) = rival(one.name) else {
            return;
        };
        let also = candidate.effect;
        if self.base.channel != Channel::Specimen || answer.alternatives.contains(&also) {
            return;
        }
        let Some(left) = self.held_out_rms(candidate) else {
            return;
        };
        let times = (left / answer.error_after.test_rms.max(f64::MIN_POSITIVE)).powi(2);
        if times >= CERTAIN {
            return;
        }
        answer.notes.push(format!(
            "{what} leaves {} {} rms of the held-out data, {} leaves {}: the two are one curve. {tells}",
            four(left),
            answer.unit,
            one.name,
            four(answer.error_after.test_rms)
        ));
        if let Some(own) = answer.members.first() {
            let probability = own.probability * times.max(LEAST_TIMES).powf(-WEIGHT).min(1.0);
            answer.members.push(Member {
                name: also,
                probability,
            });
            let whole: f64 = answer.members.iter().map(|m| m.probability).sum();
            let all = answer.members.iter_mut();
            all.for_each(|m| m.probability /= whole);
        }
        answer.alternatives.push(also);
        answer.verdict = Verdict::Ambiguous;
        answer.effects.iter_mut().for_each(|e| e.q = None);
    }

    /// What an effect leaves of the held-out data at its best on the training data, rms.
    fn held_out_rms(&self, candidate: Candidate) -> Option<f64> {
        let cutoff_hz = self.cutoff_hz();
        let problem = self.problem(self.train, cutoff_hz)?;
        let noise = self.noise(cutoff_hz)?;
        let fitted = best_alone(candidate, &problem, &self.base, &noise)?;
        Some(self.errors(&fitted, cutoff_hz).0.test_rms)
    }
}
