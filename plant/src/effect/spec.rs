//! An effect as a file names it.

use super::catalogue::Effect;
use super::row::Channel;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One of `plant.effects`: an effect and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectSpec {
    /// Which effect.
    pub name: Effect,
    /// In which channel; where it is not given, that of the parameters, else the first of the effect's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub channel: Option<Channel>,
    /// On which axis, 1 being the lowest; on all where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<usize>,
    /// The parameters by name.
    #[serde(flatten)]
    pub parameters: BTreeMap<String, f64>,
}

impl EffectSpec {
    /// `effect` with these parameters, in the channel that they belong to, on all axes.
    pub fn new(effect: Effect, parameters: &[(&str, f64)]) -> Self {
        Self {
            name: effect,
            channel: None,
            axis: None,
            parameters: parameters
                .iter()
                .map(|(name, value)| (name.to_string(), *value))
                .collect(),
        }
    }

    /// The value of a parameter: as given, else the catalogue's default.
    pub fn parameter(&self, name: &str) -> Option<f64> {
        let default = || {
            let mut known = self.name.entry().parameters.iter();
            known.find(|p| p.name == name)?.default
        };
        self.parameters.get(name).copied().or_else(default)
    }

    /// The channel that is asked for, or that a parameter belongs to, or the first of the effect's.
    pub fn shows_in(&self) -> Channel {
        let entry = self.name.entry();
        let mut given = entry
            .parameters
            .iter()
            .filter(|p| self.parameters.contains_key(p.name));
        let asked = self.channel.or_else(|| given.find_map(|p| p.channel));
        asked.unwrap_or(entry.channels[0])
    }

    /// The same in `channel`.
    pub fn in_channel(self, channel: Channel) -> Self {
        Self {
            channel: Some(channel),
            ..self
        }
    }
}
