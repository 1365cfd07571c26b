//! The rig between the structure and the computer: which actuator moves what, and what is known to be wrong with it.
//!
//! | file | what is there |
//! |---|---|
//! | [`interface`] | what the loop asks of a rig |
//! | [`command`] | what an actuator's gain and offset ask of its command |
//! | [`direct`] | each actuator moves a floor of its own |
//!
//! Two actuators on one coupler are in `coupled/rig.rs`.

mod command;
mod direct;
mod interface;

pub use command::CommandMap;
pub(crate) use direct::Known;
pub use direct::{AxisCorrection, DirectRig, MAX_SKEW_STEPS, RigConstants};
pub use interface::{Asked, Rig};
