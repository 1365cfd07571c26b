//! The list of effects: one entry a name, in the order of [`Effect`].

mod contact;
mod forces;
mod transfer;

use std::sync::LazyLock;

use super::{Channel, Effect, Entry, Family, Parameter};
use crate::error::Accept;

/// Every effect, in a fixed order.
pub fn catalogue() -> &'static [Entry] {
    static ALL: LazyLock<Vec<Entry>> =
        LazyLock::new(|| [transfer::ENTRIES, contact::ENTRIES, forces::ENTRIES].concat());
    &ALL
}

const fn effect(
    effect: Effect,
    family: Family,
    channels: &'static [Channel],
    physics: &'static str,
    parameters: &'static [Parameter],
) -> Entry {
    Entry {
        effect,
        family,
        channels,
        parameters,
        physics,
    }
}

const fn needs(
    name: &'static str,
    min: f64,
    max: f64,
    unit: &'static str,
    meaning: &'static str,
) -> Parameter {
    Parameter {
        name,
        channel: None,
        default: None,
        accept: Accept::new(min, max, unit),
        meaning,
    }
}

const fn on(channel: Channel, parameter: Parameter) -> Parameter {
    Parameter {
        channel: Some(channel),
        ..parameter
    }
}

const fn or(default: f64, parameter: Parameter) -> Parameter {
    Parameter {
        default: Some(default),
        ..parameter
    }
}

/// The least size of what divides.
const TINY: f64 = 1e-6;
const BIG: f64 = 1e9;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_has_its_entry_under_its_own_number() {
        assert_eq!(catalogue().len(), Effect::ALL.len());
        for effect in Effect::ALL {
            assert_eq!(effect.entry().effect, *effect);
        }
    }

    #[test]
    fn names_end_with_their_unit() {
        for parameter in catalogue().iter().flat_map(|e| e.parameters) {
            let unit = parameter.accept.unit.to_lowercase();
            let suffix = unit.replace('/', "_per_").replace(' ', "_");
            assert!(
                parameter.name.ends_with(&suffix),
                "{} in {unit}",
                parameter.name
            );
        }
    }
}
