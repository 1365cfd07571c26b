//! What the laboratory declares: each parameter with its standard tolerance.

use crate::Refusal;
use crate::library;
use crate::remainder::Correction;
use crate::signals::Scales;
use plant::Channel;
use serde::{Deserialize, Serialize};

/// A declared parameter. The fit may move it by three tolerances; to want more is an effect by name.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Declared {
    /// Value, in the unit of the parameter's name.
    pub value: f64,
    /// One standard tolerance, absolute.
    pub tolerance: f64,
}

/// An effect that an earlier diagnosis added.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownEffect {
    /// Its name.
    pub name: plant::Effect,
    /// Its amplitudes, in the order of the library's columns.
    pub amplitudes: Vec<f64>,
    /// Its shape parameters, in the order of the library.
    #[serde(default)]
    pub shapes: Vec<f64>,
    /// The largest displacement of the record that it was found in, mm: what powers are relative to.
    pub reference_mm: f64,
}

impl KnownEffect {
    /// What it is in the library.
    pub(crate) fn form(&self, channel: Channel) -> Option<library::Candidate> {
        library::form(channel, self.name, self.amplitudes.len(), self.shapes.len())
    }

    /// Whether the numbers are as many as the effect has, and finite.
    fn check(&self, channel: Channel) -> Result<(), Refusal> {
        let place = format!("{channel}.effects: {}", self.name);
        let candidates = library::candidates(channel);
        let Some(candidate) = candidates.iter().find(|c| c.effect == self.name) else {
            return Err(Refusal::new(format!(
                "{place} is refused: accepted are effects that the {channel} can have"
            )));
        };
        let scales = Scales::default();
        let form = self.form(channel);
        let candidate = form.as_ref().unwrap_or(candidate);
        let counts = [
            (
                "amplitudes",
                &self.amplitudes,
                (candidate.bounds)(&scales).len(),
            ),
            ("shapes", &self.shapes, (candidate.shapes)(&scales).len()),
        ];
        for (what, given, count) in counts {
            if given.len() != count || given.iter().any(|x| !x.is_finite()) {
                return Err(Refusal::new(format!(
                    "{place}.{what} = {given:?} is refused: accepted are {count} finite numbers"
                )));
            }
        }
        if !(self.reference_mm.is_finite() && self.reference_mm > 0.0) {
            return Err(Refusal::new(format!(
                "{place}.reference_mm = {} is refused: accepted are finite numbers above 0",
                self.reference_mm
            )));
        }
        Ok(())
    }

    /// A parameter of the effect by its name in the catalogue, in the catalogue's unit.
    pub fn parameter(&self, channel: plant::Channel, name: &str) -> Option<f64> {
        let candidate = self.form(channel)?;
        let scales = Scales {
            x: self.reference_mm,
            ..Scales::default()
        };
        (candidate.parameters)(&self.amplitudes, &self.shapes, &scales)
            .into_iter()
            .find(|(given, ..)| *given == name)
            .map(|(.., value)| value)
    }
}

/// Command to displacement.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
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
    pub effects: Vec<KnownEffect>,
    /// What the rest depends on, without a name: taken off the displacement before anything is asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remainder: Option<Correction>,
}

/// Displacement to force.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SpecimenModel {
    /// Stiffness, N/mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stiffness_n_per_mm: Option<Declared>,
    /// Viscous damping, N s/mm.
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
    pub effects: Vec<KnownEffect>,
    /// What the rest depends on, without a name: taken off the force before anything is asked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remainder: Option<Correction>,
}

/// The declared model; a channel that is left out is not looked at.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Command to displacement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub actuator: Option<ActuatorModel>,
    /// Displacement to force.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub specimen: Option<SpecimenModel>,
}

impl Model {
    /// Whether every number can be what it stands for.
    ///
    /// # Errors
    /// A value that is not finite, a negative tolerance, a negative delay, lag or mass.
    pub fn check(&self) -> Result<(), Refusal> {
        let actuator = self.actuator.iter().flat_map(|a| {
            [
                ("actuator.gain", a.gain, f64::MIN),
                ("actuator.delay_ms", a.delay_ms, 0.0),
                ("actuator.lag_ms", a.lag_ms, 0.0),
                ("actuator.offset_mm", a.offset_mm, f64::MIN),
            ]
        });
        let specimen = self.specimen.iter().flat_map(|s| {
            [
                (
                    "specimen.stiffness_n_per_mm",
                    s.stiffness_n_per_mm,
                    f64::MIN,
                ),
                (
                    "specimen.damping_n_s_per_mm",
                    s.damping_n_s_per_mm,
                    f64::MIN,
                ),
                ("specimen.mass_kg", s.mass_kg, 0.0),
                ("specimen.offset_n", s.offset_n, f64::MIN),
            ]
        });
        for (name, declared, least) in actuator.chain(specimen) {
            let Some(Declared { value, tolerance }) = declared else {
                continue;
            };
            if !(value.is_finite() && value >= least) {
                let from = if least == 0.0 {
                    "0 and more"
                } else {
                    "finite numbers"
                };
                return Err(Refusal::new(format!(
                    "{name}.value = {value} is refused: accepted are {from}"
                )));
            }
            if !(tolerance.is_finite() && tolerance >= 0.0) {
                return Err(Refusal::new(format!(
                    "{name}.tolerance = {tolerance} is refused: accepted are finite numbers, 0 and more"
                )));
            }
        }
        let actuator = self.actuator.iter().flat_map(|a| &a.effects);
        let specimen = self.specimen.iter().flat_map(|s| &s.effects);
        actuator
            .map(|e| (Channel::Actuator, e))
            .chain(specimen.map(|e| (Channel::Specimen, e)))
            .try_for_each(|(channel, effect)| effect.check(channel))?;
        let corrections = [
            (
                "actuator",
                self.actuator.as_ref().and_then(|a| a.remainder.as_ref()),
            ),
            (
                "specimen",
                self.specimen.as_ref().and_then(|s| s.remainder.as_ref()),
            ),
        ];
        for (name, correction) in corrections {
            if let Some(c) = correction {
                c.check(name)?;
            }
        }
        if self.actuator.is_none() && self.specimen.is_none() {
            return Err(Refusal::new(
                "the model declares no channel: accepted is a table [actuator], a table [specimen], or both",
            ));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_known_effect_has_the_numbers_of_its_kind() {
        let skew = |shapes: &[f64], reference_mm| Model {
            specimen: Some(SpecimenModel {
                effects: vec![KnownEffect {
                    name: plant::Effect::ChannelSkew,
                    amplitudes: Vec::new(),
                    shapes: shapes.to_vec(),
                    reference_mm,
                }],
                ..SpecimenModel::default()
            }),
            ..Model::default()
        };
        assert!(skew(&[1e-3], 10.0).check().is_ok());
        for (model, said) in [
            (skew(&[], 10.0), "shapes = [] is refused: accepted are 1"),
            (skew(&[f64::NAN], 10.0), "shapes = [NaN]"),
            (skew(&[1e-3], 0.0), "reference_mm = 0"),
        ] {
            let e = model.check().unwrap_err().to_string();
            assert!(e.contains(said), "{e}");
        }
    }
}
