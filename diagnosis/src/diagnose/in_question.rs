//! The names of an answer that another channel or record can test, each with the model that lacks it.

use crate::diagnose::Diagnosis;
use crate::model::Model;
use crate::model::answer::{ChannelAnswer, Verdict};
use plant::Effect;

/// A name in question.
#[derive(Clone, Debug)]
pub struct InQuestion<'a> {
    /// The answer that gave the name.
    pub answer: &'a ChannelAnswer,
    /// The model without the name.
    pub without: Model,
    /// The name; `None` if something is unknown and no name is near.
    pub name: Option<Effect>,
}

/// Each sure name, the preferred one of a set, and the nearest one if something is unknown.
pub fn in_question<'a>(model: &Model, diagnosis: &'a Diagnosis) -> Vec<InQuestion<'a>> {
    let of = |answer: &'a ChannelAnswer| -> Vec<InQuestion<'a>> {
        let one = |without: Model, name| InQuestion {
            answer,
            without,
            name,
        };
        match answer.verdict {
            Verdict::None | Verdict::NotAssessed => Vec::new(),
            Verdict::Unknown => {
                let nearest = answer.nearest.as_ref().map(|n| n.name);
                vec![one(model.clone(), nearest)]
            }
            Verdict::Ambiguous => {
                let preferred = answer.effects.first().map(|e| e.name);
                vec![one(model.clone(), preferred)]
            }
            Verdict::Effect | Verdict::Partial => {
                let names = answer.effects.iter().map(|e| e.name);
                let each = names.map(|name| {
                    let without = diagnosis.improved.without(answer.channel, name);
                    one(without, Some(name))
                });
                each.collect()
            }
        }
    };
    diagnosis.channels.iter().flat_map(of).collect()
}
