//! The parts of a catalogue row.

use crate::error::Accept;
use serde::{Deserialize, Serialize};
use std::fmt;

macro_rules! named {
    ($(#[$doc:meta])* $name:ident { $($variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, schemars::JsonSchema)]
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
pub(super) use named;

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

/// A parameter of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name, ending with the unit if it has one.
    pub name: &'static str,
    /// The channel that it belongs to; `None`: every channel of the effect.
    pub channel: Option<Channel>,
    /// Default value; `None`: it must be given.
    pub default: Option<f64>,
    /// Accepted values and their unit.
    pub accept: Accept,
    /// Its meaning.
    pub meaning: &'static str,
}
