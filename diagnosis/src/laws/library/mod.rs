//! The library: the contribution of each effect to a channel's response, as columns with fitted amplitudes and searched
//! shapes.

mod actuator;
pub(crate) mod candidate;
pub(crate) mod saved;
mod specimen;

pub use candidate::{Candidate, Known};
pub use saved::form_names;
pub use specimen::{CANDIDATES, OFF_CENTRE_LIMIT, ROUNDED_GAP, ROUNDED_LIMIT};

use plant::{Channel, Effect, EffectSpec};

/// All effects that a model of a channel may have.
fn effects(channel: Channel) -> Vec<Known> {
    match channel {
        Channel::Actuator => actuator::EFFECTS.to_vec(),
        Channel::Specimen => CANDIDATES.iter().map(Candidate::known).collect(),
    }
}

/// True if a model of a channel may have an effect.
pub fn has(channel: Channel, effect: Effect) -> bool {
    effects(channel).iter().any(|k| k.effect == effect)
}

/// The library's entry for an effect of a model, or for one of its forms if it has the form's parameters.
pub fn known(channel: Channel, effect: &EffectSpec) -> Option<Known> {
    let forms = match channel {
        Channel::Actuator => actuator::FORMS,
        Channel::Specimen => specimen::FORMS,
    };
    let form = saved::form_of(channel, effect).and_then(|i| forms.get(i).copied());
    let form = form.or_else(|| saved::tires(effect).then_some(specimen::FATIGUE.known()));
    let mut all = effects(channel).into_iter();
    form.or_else(|| all.find(|k| k.effect == effect.name))
}

#[cfg(test)]
mod tests {
    use super::saved::fit_of;
    use super::*;
    use crate::numbers::signals::{Scales, Transfer};

    #[test]
    fn every_name_has_a_candidate_in_every_channel_of_the_catalogue() {
        for entry in plant::catalogue() {
            for &channel in entry.channels {
                // Quantisation is read from the values themselves; a sensor that freezes or is noisier is not a model
                // of a record.
                let found = has(channel, entry.effect);
                assert_eq!(
                    found,
                    !matches!(
                        entry.effect,
                        Effect::Quantisation | Effect::FrozenSensor | Effect::SensorNoise
                    ),
                    "{} {channel}",
                    entry.effect
                );
            }
        }
    }

    #[test]
    fn every_form_has_the_names_of_its_shapes() {
        for (channel, forms) in [
            (Channel::Actuator, actuator::FORMS),
            (Channel::Specimen, specimen::FORMS),
        ] {
            let names = saved::forms(channel).iter().map(|(effect, _)| *effect);
            assert!(names.eq(forms.iter().map(|c| c.effect)));
        }
    }

    #[test]
    fn parameters_are_those_of_the_catalogue() {
        let scales = Scales {
            x: 10.0,
            v: 100.0,
            base: 1000.0,
            stiffness: 100.0,
            seconds: 20.0,
            interval_s: 1e-3,
            step_s: 1e-3,
            actuator: Transfer {
                gain: 1.0,
                delay_s: 5e-3,
                lag_s: 2e-2,
                offset_mm: 0.0,
            },
            declared: Transfer {
                gain: 1.0,
                delay_s: 5e-3,
                lag_s: 2e-2,
                offset_mm: 0.0,
            },
            line_hz: None,
        };
        for c in CANDIDATES {
            let shapes: Vec<f64> = (c.shapes)(&scales)
                .iter()
                .map(|s| s.high.min((s.low * s.high).abs().sqrt()))
                .collect();
            let amplitudes = vec![0.5; (c.bounds)(&scales).len()];
            let named = (c.parameters)(&amplitudes, &shapes, &scales);
            let values: Vec<_> = named
                .iter()
                .map(|(name, _, value)| (*name, *value))
                .collect();
            // The file contains only these: reading them back gives the same.
            let saved = plant::EffectSpec::new(c.effect, &values);
            let (a, p) = fit_of(Channel::Specimen, &saved, &scales);
            for ((name, _, value), (_, _, again)) in
                named.iter().zip((c.parameters)(&a, &p, &scales))
            {
                let room = 1e-9 * value.abs() + 1e-12;
                assert!(
                    (value - again).abs() < room,
                    "{c:?}: {name} {value} {again}"
                );
            }
            for (name, unit, value) in named {
                let known = c.effect.entry().parameters.iter().find(|p| p.name == name);
                let known = known.unwrap_or_else(|| panic!("{c:?}: {name}"));
                assert_eq!(known.accept.unit, unit, "{c:?}: {name}");
                assert!(value.is_finite(), "{c:?}: {name} = {value}");
            }
        }
    }
}
