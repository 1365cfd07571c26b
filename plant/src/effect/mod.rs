//! Effects that a declared model may lack, by the names that the diagnosis answers with.
//!
//! Any of them can be added to any rig, any number of times: `plant.effects = [{ name = "coulomb_friction", force_n = 20 }]`.
//! What each of them is, in which channel and with which parameters, is in [`catalogue`]; an effect in the `actuator`
//! channel shows between command and displacement, one in the `specimen` channel between displacement and force.

macro_rules! named {
    ($(#[$doc:meta])* $name:ident { $($variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        pub enum $name {
            $(#[doc = concat!("`", $text, "`")] #[serde(rename = $text)] $variant,)*
        }

        impl $name {
            /// The name in files and answers.
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $text,)* }
            }

            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.pad(self.name())
            }
        }
    };
}

mod additions;
mod catalogue;
mod given;

pub(crate) use additions::{Additions, Signal, additions};
pub use catalogue::{Effect, catalogue};

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::error::{Accept, RigError};

named! {
    /// Effects of one kind.
    Family {
        Timing = "timing",
        Calibration = "calibration",
        Slow = "slow",
        Friction = "friction",
        Hysteresis = "hysteresis",
        Gap = "gap",
        Limit = "limit",
        Damping = "damping",
        Stiffness = "stiffness",
        Asymmetry = "asymmetry",
        Inertia = "inertia",
        Interference = "interference",
    }
}

named! {
    /// Where an effect shows.
    Channel {
        Actuator = "actuator",
        Specimen = "specimen",
    }
}

/// What is known of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// Its name.
    pub effect: Effect,
    /// Its family.
    pub family: Family,
    /// Where it can show; the first where the rig is not told otherwise.
    pub channels: &'static [Channel],
    /// What it is described by.
    pub parameters: &'static [Parameter],
    /// What happens, in a line.
    pub physics: &'static str,
}

/// A parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name, ending with the unit where it has one.
    pub name: &'static str,
    /// The channel that it belongs to; none: to every channel of the effect.
    pub channel: Option<Channel>,
    /// Taken where it is not given; none: it must be.
    pub default: Option<f64>,
    /// Accepted values and their unit.
    pub accept: Accept,
    /// What it is.
    pub meaning: &'static str,
}

impl Effect {
    /// What is known of it.
    pub fn entry(self) -> &'static Entry {
        &catalogue()[self as usize]
    }
}

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

    /// Checks that name, channel and parameters fit each other; `path` is where this is in its file.
    ///
    /// # Errors
    /// A parameter that is missing, unknown or out of its range, by its name.
    pub fn check(&self, path: &str) -> Result<(), RigError> {
        given::Given::new(self, path).map(drop)
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
