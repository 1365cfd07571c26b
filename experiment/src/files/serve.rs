//! `[serve]`: how a rig serves an external program.

use outerloop_core::{Pace, Refusal, accept};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The `[serve]` table: how `outerloop serve` moves the rig, and the units on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// How the actuator goes from target to target: `stop_and_go` or `continuous`.
    pub pace: Pace,
    /// Stop and go: how long the rig stands at a target before it is read, ms.
    pub settle_ms: f64,
    /// Stop and go: the time over which displacement and force are averaged then, ms.
    pub average_ms: f64,
    /// Stop and go: the force is carried from the displacement that was reached to the one that was asked for, with the
    /// declared stiffness.
    pub carry_force: bool,
    /// How long a client may be silent, s.
    pub timeout_s: f64,
    /// Unit of length on the wire.
    pub length_unit: Length,
    /// Unit of force on the wire.
    pub force_unit: Force,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            pace: Pace::StopAndGo,
            settle_ms: 5.0,
            average_ms: 2.0,
            carry_force: true,
            timeout_s: 60.0,
            length_unit: Length::Metre,
            force_unit: Force::Newton,
        }
    }
}

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Length {
    /// m.
    #[serde(rename = "m")]
    Metre,
    /// cm.
    #[serde(rename = "cm")]
    Centimetre,
    /// mm.
    #[serde(rename = "mm")]
    Millimetre,
    /// in.
    #[serde(rename = "in")]
    Inch,
    /// ft.
    #[serde(rename = "ft")]
    Foot,
}

impl Length {
    /// Metres per unit.
    pub const fn metres(self) -> f64 {
        match self {
            Self::Metre => 1.0,
            Self::Centimetre => 0.01,
            Self::Millimetre => 1e-3,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }
}

/// A unit of force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Force {
    /// N.
    #[serde(rename = "N")]
    Newton,
    /// kN.
    #[serde(rename = "kN")]
    Kilonewton,
    /// MN.
    #[serde(rename = "MN")]
    Meganewton,
    /// Pounds of force.
    #[serde(rename = "lbf")]
    Pound,
    /// 1000 pounds of force.
    #[serde(rename = "kip")]
    Kip,
}

impl Force {
    /// Newtons per unit.
    pub const fn newtons(self) -> f64 {
        match self {
            Self::Newton => 1.0,
            Self::Kilonewton => 1e3,
            Self::Meganewton => 1e6,
            Self::Pound => 4.448_221_615_260_5,
            Self::Kip => 4_448.221_615_260_5,
        }
    }
}

impl Settings {
    /// Checks every number.
    ///
    /// # Errors
    /// The first inadmissible one.
    pub fn check(&self) -> Result<(), Refusal> {
        let (settle_ms, average_ms, timeout_s) = (self.settle_ms, self.average_ms, self.timeout_s);
        let short = |ms: f64| (0.0..=60_000.0).contains(&ms);
        let within_a_day = timeout_s > 0.0 && timeout_s <= 86_400.0;
        accept(
            "serve.settle_ms",
            settle_ms,
            short(settle_ms),
            "0 to 60000 ms",
        )?;
        accept(
            "serve.average_ms",
            average_ms,
            short(average_ms),
            "0 to 60000 ms",
        )?;
        accept(
            "serve.timeout_s",
            timeout_s,
            within_a_day,
            "above 0 to 86400 s",
        )
    }
}
