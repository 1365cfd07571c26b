//! An effect as named in a file.

use super::catalogue::Effect;
use super::row::Channel;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A measuring channel of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Sensor {
    /// The displacement transducer.
    Displacement,
    /// The load cell.
    Force,
}

/// One of `plant.effects`: an effect and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct EffectSpec {
    /// Which effect; beside `frozen = true` it may be left out.
    #[serde(default = "frozen_sensor")]
    pub name: Effect,
    /// In which channel; where it is not given, that of the parameters, else the first of the effect's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<Channel>,
    /// On which axis, 1 being the lowest; on all where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<usize>,
    /// Seconds of the model, from the first control step of the running test, at which it begins; from the start where it
    /// is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// The sensor that it is an error of, `displacement` or `force`: the reading is wrong and the motion is not. Without it
    /// an effect in the actuator channel is one of the motion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Sensor>,
    /// True: that sensor reads on what it read when this began, and its noise.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub frozen: bool,
    /// Whether it acts; one that does not is kept for being tried.
    #[serde(default = "yes", skip_serializing_if = "Clone::clone")]
    pub enabled: bool,
    /// The parameters by name.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, f64>,
}

fn frozen_sensor() -> Effect {
    Effect::FrozenSensor
}

const fn yes() -> bool {
    true
}

impl EffectSpec {
    /// `effect` with these parameters, in their channel, on all axes.
    ///
    /// ```
    /// use plant::{Effect, RigSpec};
    ///
    /// let rig = RigSpec::default().with_effect(Effect::Backlash, &[("width_mm", 0.2)])?;
    /// assert_eq!(rig.effects[0].parameter("width_mm"), Some(0.2));
    /// let refused = RigSpec::default().with_effect(Effect::Backlash, &[("width_mm", -1.0)]);
    /// assert!(refused.unwrap_err().to_string().contains("width_mm"));
    /// # Ok::<(), plant::RigError>(())
    /// ```
    pub fn new(effect: Effect, parameters: &[(&str, f64)]) -> Self {
        Self {
            name: effect,
            channel: None,
            axis: None,
            from_s: None,
            sensor: None,
            frozen: false,
            enabled: true,
            parameters: parameters
                .iter()
                .map(|(name, value)| (name.to_string(), *value))
                .collect(),
        }
    }

    /// The value of a parameter: as given, otherwise the catalogue's default.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        let default = || {
            let mut known = self.name.entry().parameters.iter();
            known.find(|p| p.name == name)?.default
        };
        self.parameters.get(name).copied().or_else(default)
    }

    /// True if it is present from the start and is not an error of a single sensor, so that a model can declare it.
    pub fn is_of_the_whole_test(&self) -> bool {
        self.from_s.is_none() && self.sensor.is_none()
    }

    /// The requested channel, or that of its sensor, or the one that a parameter belongs to, or the effect's first.
    pub fn shows_in(&self) -> Channel {
        let entry = self.name.entry();
        let mut given = entry
            .parameters
            .iter()
            .filter(|p| self.parameters.contains_key(p.name));
        let read_in = self.sensor.map(|sensor| match sensor {
            Sensor::Displacement => Channel::Actuator,
            Sensor::Force => Channel::Specimen,
        });
        let asked = self.channel.or(read_in);
        let asked = asked.or_else(|| given.find_map(|p| p.channel));
        asked.unwrap_or(entry.channels[0])
    }

    /// The same effect in `channel`.
    pub fn in_channel(self, channel: Channel) -> Self {
        Self {
            channel: Some(channel),
            ..self
        }
    }
}
