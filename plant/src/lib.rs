//! The simulated rig of a fast pseudodynamic test, in f64 on the host: what a command becomes on its way through
//! actuator, specimen, sensors and converters. It shares no equation with the loop that it is to judge.
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
//! | [`measurement`] | what the loop gets to see of both: sampling skew, [`sensor`], [`converter`] |
//! | [`kinematics`] | velocity and acceleration in lab time |
//!
//! Time is lab time: one [`Rig::step`] is one control period. A sample is taken at the *end* of the period in which the
//! actuator had its command, so an ideal actuator's displacement equals the command of the same step.

pub mod actuator;
pub mod converter;
mod error;
pub mod kinematics;
pub mod measurement;
mod per_axis;
mod random;
pub mod rig;
pub mod sensor;
pub mod specimen;

pub use error::RigError;
pub use per_axis::PerAxis;
pub use rig::{Reading, Rig, RigSpec};
