//! From command to displacement.
//!
//! Commands are held by the converter over a control period, and the displacement is sampled at its end. A lag that is
//! exact for the held command therefore *leads* the same lag driven by linearly interpolated commands by half a period:
//! its low-frequency delay relative to the command sequence is `delay_ms` minus half a period.

mod dynamics;
mod load;
mod random_multiplier;
mod servo_hydraulic;
mod spec;

pub use dynamics::Actuator;
pub use load::Load;
pub use random_multiplier::RandomMultiplier;
pub use servo_hydraulic::{ServoHydraulic, ServoSpec};
pub use spec::{ActuatorKind, ActuatorSpec, DelayJump};
