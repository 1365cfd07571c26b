//! From command to displacement.
//!
//! Commands are held by the converter over a control period, and the displacement is sampled at its end. A lag that is
//! exact for the held command is therefore half a period *ahead* of the same lag driven by the commands joined by
//! straight lines: its low-frequency delay behind the sequence of commands is `delay_ms` less half a period.

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
