//! The numbers of a model that a fit may move, and the change of its response with them.

use super::predict::{Planned, answer};
use crate::criteria::REACH;
use crate::model::Model;
use crate::numbers::signals::difference_quotient;
use plant::Channel;

/// A number of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelNumber {
    which: Which,
    /// Its name, ending with its unit.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its possible error without any record: three tolerances, or its own size.
    pub spread: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Which {
    /// One of the channel's four declared parameters.
    Declared(usize),
    /// An effect's parameter.
    Effect(usize, String),
    /// An element's strength.
    Strength(usize),
    /// An element's shape.
    Shape(usize, usize),
}

/// Step of a derivative, as a fraction of a number's spread.
const STEP: f64 = 0.02;

/// The numbers of a channel, except those that `before` had with the same value and without a tolerance.
pub fn numbers(model: &Model, before: &Model, channel: Channel) -> Vec<ModelNumber> {
    let Some(own) = model.channel(channel) else {
        return Vec::new();
    };
    let mut all = Vec::new();
    let was = before.channel(channel).map_or([None; 4], |b| b.parameters);
    for (i, now) in own.parameters.into_iter().enumerate() {
        let Some(now) = now else { continue };
        let tolerance = was[i].map_or(now.tolerance, |w| w.tolerance.max(now.tolerance));
        let moved = was[i].is_none_or(|w| w.value != now.value);
        let spread = if tolerance > 0.0 {
            REACH * tolerance
        } else if moved {
            now.value.abs()
        } else {
            0.0
        };
        let name = channel.parameters()[i].name.to_owned();
        all.push((Which::Declared(i), name, now.value, spread));
    }
    let effects = own.effects.iter().enumerate();
    for (i, effect) in effects.filter(|e| e.1.enabled) {
        for (name, value) in &effect.parameters {
            let label = format!("{} {name}", effect.name);
            all.push((Which::Effect(i, name.clone()), label, *value, value.abs()));
        }
    }
    let elements = own.elements.iter().enumerate();
    for (i, element) in elements.filter(|e| e.1.enabled) {
        let strength = element.strength;
        let label = format!("{} strength", element.name);
        all.push((Which::Strength(i), label, strength, strength.abs()));
        for k in element.free_shapes() {
            let value = element.shape[k];
            let label = format!("{} shape {}", element.name, k + 1);
            all.push((Which::Shape(i, k), label, value, 0.5 * value.abs()));
        }
    }
    all.into_iter()
        .filter(|l| l.3 > 0.0)
        .map(|(which, name, value, spread)| ModelNumber {
            which,
            name,
            value,
            spread,
        })
        .collect()
}

/// The model with one number moved.
fn moved(model: &Model, channel: Channel, number: &ModelNumber, by: f64) -> Model {
    let mut model = model.clone();
    match &number.which {
        Which::Declared(i) => {
            if let Some((places, _)) = model.channel_mut(channel)
                && let Some(d) = places[*i].as_mut()
            {
                d.value += by;
            }
        }
        Which::Effect(i, name) => {
            if let Some((_, effects)) = model.channel_mut(channel)
                && let Some(value) = effects[*i].parameters.get_mut(name)
            {
                *value += by;
            }
        }
        Which::Strength(i) => {
            if let Some(e) = element(&mut model, *i) {
                e.strength += by;
            }
        }
        Which::Shape(i, k) => {
            if let Some(e) = element(&mut model, *i) {
                e.shape[*k] += by;
            }
        }
    }
    model
}

fn element(model: &mut Model, i: usize) -> Option<&mut crate::model::saved_element::SavedElement> {
    model.specimen.as_mut()?.elements.get_mut(i)
}

/// Change of the response with each number, a column each, per spread of the number.
pub fn slopes(
    model: &Model,
    channel: Channel,
    numbers: &[ModelNumber],
    planned: &Planned<'_>,
    here: &[f64],
) -> Vec<Vec<f64>> {
    let column = |number: &ModelNumber| {
        let by = STEP * number.spread;
        let there = answer(&moved(model, channel, number, by), channel, planned)?;
        Some(difference_quotient(&there, here, STEP))
    };
    let still = || vec![0.0; here.len()];
    numbers
        .iter()
        .map(|l| column(l).unwrap_or_else(still))
        .collect()
}
