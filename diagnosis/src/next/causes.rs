//! What is still possible after a diagnosis, each as a whole model.

use crate::answer::{ChannelAnswer, Verdict};
use crate::engine;
use crate::model::Model;
use crate::recording::Recording;
use plant::{Channel, Effect, Family};

/// A model that is still possible.
#[derive(Clone, Debug)]
pub struct Cause {
    /// What it has that the declared model lacks; none: nothing.
    pub name: Option<Effect>,
    /// How probable it is, where the diagnosis says so.
    pub probability: Option<f64>,
    /// The whole model.
    pub model: Model,
}

/// Where nothing can be vouched for, so many of the nearest names are told apart.
const NEAREST: usize = 4;
/// What leaves more than this many times the rms of the best is none of the nearest.
const FAR: f64 = 1.5;

/// What is left of the training data by a model with one name more.
type FittedModel = (Effect, Model, f64);

/// The models between which the answer of a channel leaves the choice, the preferred one first; one alone where it leaves
/// none.
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
            let rivals = fitted(declared, answer.channel, train, wanted);
            let rivals = rivals.into_iter().map(|(name, model, _)| Cause {
                name: Some(name),
                probability: probability(name),
                model,
            });
            std::iter::once(preferred).chain(rivals).collect()
        }
        Verdict::Partial | Verdict::Unknown => {
            // What is missing still, or at all: the nearest of each family.
            let known: Vec<Effect> = answer.effects.iter().map(|e| e.name).collect();
            // A line in the mains' band is no matter of the motion.
            let wanted = |name: Effect| {
                !known.contains(&name) && name.entry().family != Family::Interference
            };
            let all = fitted(improved, answer.channel, train, wanted);
            let most = all.first().map_or(0.0, |f| FAR * f.2);
            let mut families: Vec<Family> = Vec::new();
            let mut nearest: Vec<Cause> = Vec::new();
            for (name, model, left) in all {
                let family = name.entry().family;
                if left <= most && !families.contains(&family) && nearest.len() < NEAREST {
                    families.push(family);
                    nearest.push(Cause {
                        name: Some(name),
                        probability: None,
                        model,
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

/// One model for each wanted name, best first; each name with the form that leaves least.
fn fitted(
    model: &Model,
    channel: Channel,
    train: &[Recording],
    wanted: impl Fn(Effect) -> bool + Sync,
) -> Vec<FittedModel> {
    let all = match channel {
        Channel::Specimen => engine::one_each(model, train, wanted),
        Channel::Actuator => engine::actuator_each(model, train, &wanted),
    };
    let mut all = all.unwrap_or_default();
    all.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut names: Vec<Effect> = Vec::new();
    all.retain(|f| {
        let new = !names.contains(&f.0);
        names.push(f.0);
        new
    });
    all
}
