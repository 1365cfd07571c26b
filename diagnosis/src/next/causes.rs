//! What remains possible after a diagnosis, each as a whole model.

use crate::engine;
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Verdict};
use crate::record::recording::Recording;
use plant::{Effect, Family};

/// A model that remains possible.
#[derive(Clone, Debug)]
pub struct Cause {
    /// What it has and the declared model lacks; `None`: nothing.
    pub name: Option<Effect>,
    /// Its probability, if the diagnosis gives one.
    pub probability: Option<f64>,
    /// The whole model.
    pub model: Model,
}

/// Number of nearest names to tell apart if no name could be confirmed.
const NEAREST: usize = 4;
/// Largest rms residual of a nearest name, relative to the best.
const FAR: f64 = 1.5;

/// The models between which a channel's answer leaves the choice open, the preferred one first; a single one if the
/// choice is not open.
pub fn causes(
    declared: &Model,
    improved: &Model,
    answer: &ChannelAnswer,
    train: &[Recording],
) -> Vec<Cause> {
    let preferred = Cause {
        name: answer.effects.first().map(|e| e.name),
        probability: answer.members.first().map(|m| m.probability),
        model: improved.clone(),
    };
    match answer.verdict {
        Verdict::Ambiguous => {
            let probability = |name| {
                let own = answer.members.iter().find(|m| m.name == name);
                own.map(|m| m.probability)
            };
            let wanted = |name| answer.alternatives.contains(&name);
            let rivals = engine::each(declared, answer.channel, train, wanted);
            let rivals = rivals.into_iter().map(|own| Cause {
                name: Some(own.name),
                probability: probability(own.name),
                model: own.model,
            });
            std::iter::once(preferred).chain(rivals).collect()
        }
        Verdict::Partial | Verdict::Unknown => {
            // Candidates for what is still missing: the nearest of each family.
            let known: Vec<Effect> = answer.effects.iter().map(|e| e.name).collect();
            // A line in the mains band does not depend on the motion.
            let wanted = |name: Effect| {
                !known.contains(&name) && name.entry().family != Family::Interference
            };
            let all = engine::each(improved, answer.channel, train, wanted);
            let most = all.first().map_or(0.0, |f| FAR * f.left_rms);
            let mut families: Vec<Family> = Vec::new();
            let mut nearest: Vec<Cause> = Vec::new();
            for own in all {
                let family = own.name.entry().family;
                if own.left_rms <= most && !families.contains(&family) && nearest.len() < NEAREST {
                    families.push(family);
                    nearest.push(Cause {
                        name: Some(own.name),
                        probability: None,
                        model: own.model,
                    });
                }
            }
            if nearest.is_empty() {
                vec![preferred]
            } else {
                nearest
            }
        }
        Verdict::None | Verdict::Effect | Verdict::NotAssessed => vec![preferred],
    }
}
