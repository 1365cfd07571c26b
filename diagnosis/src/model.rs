//! What the laboratory declares: each parameter with its standard tolerance.

pub mod answer;
pub mod base;
pub mod channel;
pub mod coordinates;
pub mod declared;
pub mod interval;
pub mod saved_element;

use crate::laws::library;
use crate::model::answer::Correction;
use crate::model::coordinates::CoupledSpecimen;
pub use crate::model::declared::Declared;
use crate::model::declared::LARGEST_TOLERANCE;
use crate::model::saved_element::SavedElement;
use crate::record::refusal::Refusal;
use plant::{Channel, ChannelParameter, Effect, EffectSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Checks an effect that an earlier diagnosis added to `channel`, using the wording of `plant.effects`.
fn check_effect(channel: Channel, effect: &EffectSpec) -> Result<(), Refusal> {
    let place = format!("{channel}.effects");
    if effect.name == Effect::Quantisation {
        return Err(Refusal::new(format!(
            "{place}: quantisation is refused: it is read off the values of a record, and a model works the same with or \
             without it: leave it out"
        )));
    }
    if !effect.is_of_the_whole_test() || effect.frozen {
        return Err(Refusal::new(format!(
            "{place}: from_s, sensor and frozen of {} are refused: accepted is what acts from the start; they are keys of a \
             simulated rig, plant.effects",
            effect.name
        )));
    }
    if !library::has(channel, effect.name) {
        return Err(Refusal::new(format!(
            "{place}: {} is refused: accepted are effects that the {channel} can have",
            effect.name
        )));
    }
    // A form has its own parameters, in addition to those of the catalogue.
    let own = library::form_names(channel, effect);
    if let Some((name, value)) = own.iter().find_map(|name| {
        let value = effect.parameters.get(*name)?;
        (!value.is_finite()).then_some((name, value))
    }) {
        return Err(Refusal::new(format!(
            "{place}: {name} of {} is {value}: accepted are finite numbers",
            effect.name
        )));
    }
    if !own.is_empty() {
        return Ok(());
    }
    let here = effect.clone().in_channel(channel);
    here.check(&place).map_err(|e| Refusal::new(e.to_string()))
}

/// Checks the value and the tolerance of a parameter.
fn check_declared(
    channel: Channel,
    parameter: &ChannelParameter,
    declared: Declared,
) -> Result<(), Refusal> {
    let name = format!("{channel}.{}", parameter.name);
    let Declared { value, tolerance } = declared;
    if !(value.is_finite() && value >= parameter.least) {
        let from = if parameter.least == 0.0 {
            "0 and more"
        } else {
            "finite numbers"
        };
        return Err(Refusal::new(format!(
            "{name}.value = {value} is refused: accepted are {from}"
        )));
    }
    if !(0.0..=LARGEST_TOLERANCE).contains(&tolerance) {
        return Err(Refusal::new(format!(
            "{name}.tolerance = {tolerance:e} is refused: accepted are 0 to 1e9"
        )));
    }
    Ok(())
}

/// Command to displacement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ActuatorModel {
    /// Displacement per command; 1 where it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gain: Option<Declared>,
    /// Transport delay, ms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delay_ms: Option<Declared>,
    /// Time constant of a first-order lag, ms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lag_ms: Option<Declared>,
    /// Displacement at command 0, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_mm: Option<Declared>,
    /// What earlier diagnoses added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSpec>,
    /// What the remaining error depends on, without a name: taken off the displacement before anything is asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remainder: Option<Correction>,
}

/// Unit of the force that a specimen's parameters are in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum ForceUnit {
    /// Newtons.
    #[default]
    #[serde(rename = "N")]
    Newton,
    /// None: a recorded force without a unit, such as a normalised one. The N of the parameters' names stand for the
    /// record's own unit.
    #[serde(rename = "1")]
    Without,
}

impl ForceUnit {
    fn is_newton(&self) -> bool {
        *self == Self::Newton
    }
}

/// Displacement to force.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpecimenModel {
    /// What the N in the names of the parameters are: newtons, or 1 for a recorded force without a unit.
    #[serde(default, skip_serializing_if = "ForceUnit::is_newton")]
    pub force_unit: ForceUnit,
    /// Stiffness, N/mm; `structure.stiffness_n_per_m` of a test file is in N/m: 158 N/mm are 158000 N/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_n_per_mm: Option<Declared>,
    /// Viscous damping, N s/mm: 1 N s/mm is 1000 N s/m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub damping_n_s_per_mm: Option<Declared>,
    /// Mass that hangs on the load cell, kg.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass_kg: Option<Declared>,
    /// Force at rest, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_n: Option<Declared>,
    /// What earlier diagnoses added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSpec>,
    /// What the remaining error depends on, without a name: taken off the force before anything is asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remainder: Option<Correction>,
    /// Elements beside the specimen, of a strength of their own, that earlier diagnoses added.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub elements: Vec<SavedElement>,
}

/// What the rig may do, around its zero; what is left out is taken from a record's own span.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RigLimits {
    /// Largest displacement to either side, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement_mm: Option<f64>,
    /// Top speed, mm/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub velocity_mm_per_s: Option<f64>,
    /// Largest force of either sign, N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_n: Option<f64>,
}

impl RigLimits {
    fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    fn check(&self) -> Result<(), Refusal> {
        let all = [
            ("displacement_mm", self.displacement_mm),
            ("velocity_mm_per_s", self.velocity_mm_per_s),
            ("force_n", self.force_n),
        ];
        let wrong = |x: f64| !(x.is_finite() && x > 0.0);
        match all
            .iter()
            .find_map(|(name, x)| Some((name, (*x)?)).filter(|(_, x)| wrong(*x)))
        {
            None => Ok(()),
            Some((name, value)) => Err(Refusal::new(format!(
                "limits.{name} = {value} is refused: accepted are numbers above 0"
            ))),
        }
    }
}

/// The declared model; a channel that is left out is not looked at. A file of its own, as `diagnose --model` takes it, has the same
/// tables without `declared.`; `outerloop new --model FILE` writes one with every key explained.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Command to displacement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actuator: Option<ActuatorModel>,
    /// Displacement to force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub specimen: Option<SpecimenModel>,
    /// Displacement to force of a specimen of several coordinates; it stands alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coupled: Option<CoupledSpecimen>,
    /// What the rig may do: a next test is designed inside it.
    #[serde(default, skip_serializing_if = "RigLimits::is_empty")]
    pub limits: RigLimits,
}

impl Model {
    /// Checks that every number is admissible.
    ///
    /// # Errors
    /// A value that is not finite, a negative tolerance, a negative delay, lag or mass, a limit that is not above 0.
    pub fn check(&self) -> Result<(), Refusal> {
        self.limits.check()?;
        if let Some(coupled) = &self.coupled {
            if self.actuator.is_some() || self.specimen.is_some() {
                return Err(Refusal::new(
                    "the model declares [coupled] beside [actuator] or [specimen]: accepted is one or the other",
                ));
            }
            return coupled.check();
        }
        for &channel in Channel::ALL {
            let Some(own) = self.channel(channel) else {
                continue;
            };
            for (parameter, declared) in channel.parameters().iter().zip(own.parameters) {
                if let Some(declared) = declared {
                    check_declared(channel, parameter, declared)?;
                }
            }
            own.elements.iter().try_for_each(SavedElement::check)?;
            let mut effects = own.effects.iter();
            effects.try_for_each(|effect| check_effect(channel, effect))?;
            if let Some(correction) = own.remainder {
                correction.check(channel.name())?;
            }
        }
        if self.actuator.is_none() && self.specimen.is_none() {
            return Err(Refusal::new(
                "the model declares no channel: accepted is a table [actuator], a table [specimen], or both; a table \
                 [coupled] for a specimen of several coordinates",
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_effect_has_the_parameters_of_the_catalogue() {
        let with = |effect: EffectSpec| Model {
            specimen: Some(SpecimenModel {
                effects: vec![effect],
                ..SpecimenModel::default()
            }),
            ..Model::default()
        };
        let of = |effect, parameters: &[(&str, f64)]| with(EffectSpec::new(effect, parameters));
        use plant::Effect::{ChannelSkew, CoulombFriction, RateLimit};
        assert!(of(ChannelSkew, &[("skew_ms", 1.0)]).check().is_ok());
        for (model, said) in [
            (of(ChannelSkew, &[]), "skew_ms of channel_skew is missing"),
            (of(ChannelSkew, &[("skew_ms", f64::NAN)]), "is NaN"),
            (
                of(CoulombFriction, &[("error_mm", 1.0)]),
                "in the specimen channel force_n",
            ),
            (
                of(RateLimit, &[("rate_mm_per_s", 1.0)]),
                "rate_limit is refused",
            ),
        ] {
            let e = model.check().unwrap_err().to_string();
            assert!(e.contains(said), "{e}");
        }
    }
}
