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
//! | [`specimen`] | displacement to force: one restoring-force element per storey |
//! | `frame` | storeys to floors, and floors that give way |
//! | [`measurement`] | how the loop sees both: sampling skew, [`sensor`], [`converter`] |
//! | `parameters` | a laboratory's declaration of a rig: one row per parameter |
//! | [`coupled`] | two actuators on one coupler, instead of the above: x and rotation |
//! | [`effect`] | further possible errors of a rig, by name: the list used in the diagnosis' answers |
//! | [`random`] | seeded noise: one stream per purpose |
//! | `stage` | an effect's element in the path of a displacement or a signal |
//! | [`kinematics`] | velocity and acceleration in lab time |
//!
//! Time is lab time: one [`Rig::step`] is one control period. A sample is taken at the *end* of the period in which its
//! command was held, so an ideal actuator's displacement equals the command of the same step.

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
