#![doc = include_str!("../README.md")]
//!
//! # Map
//!
//! ```text
//!  command ─► actuator ─► floor displacement ─► storey drift ─► storey shear ─► floor force
//!             actuator/        │                 specimen/                          │
//!                              ▼                                                    ▼
//!                         sensor + converter                               sensor + converter
//!                              │                                                    │
//!                              └──────────────────► Reading ◄───────────────────────┘
//! ```
//!
//! | look in | for |
//! |---|---|
//! | [`rig`] | the composition: [`RigSpec`] is the `[plant]` table of a test file, [`Rig::step`] one control period |
//! | [`actuator`] | command to displacement: delays, lags, the random multiplier, a servo-hydraulic actuator |
//! | [`specimen`] | displacement to force: one restoring-force element a storey |
//! | `frame` | storeys to floors, and floors that give way |
//! | [`measurement`] | what the loop gets to see of both: sampling skew, [`sensor`], [`converter`] |
//! | `parameters` | what a laboratory declares of a rig: one row a parameter |
//! | [`coupled`] | two actuators on one coupler, in place of the above: x and rotation |
//! | [`effect`] | what else may be wrong with a rig, by name: the list that the diagnosis answers with |
//! | [`random`] | seeded noise: one stream a purpose |
//! | `stage` | what an effect puts into the way of a displacement or a signal |
//! | [`kinematics`] | velocity and acceleration in lab time |
//!
//! Time is lab time: one [`Rig::step`] is one control period. A sample is taken at the *end* of the period in which the
//! actuator had its command, so an ideal actuator's displacement equals the command of the same step.

pub mod actuator;
pub mod converter;
pub mod coupled;
pub mod delay_line;
pub mod effect;
mod error;
mod frame;
pub mod kinematics;
pub mod lag;
pub mod linear;
pub mod measurement;
mod parameters;
mod per_axis;
pub mod random;
pub mod rig;
pub mod sensor;
pub mod specimen;
mod stage;

pub use effect::{Channel, Effect, EffectSpec, Family, Sensor, catalogue};
pub use error::{Accept, RigError};
pub use parameters::ChannelParameter;
pub use per_axis::PerAxis;
pub use rig::{Reading, Rig, RigSpec};
