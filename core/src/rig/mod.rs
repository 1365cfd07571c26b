//! The rig between the structure and the computer: which actuator moves what, and the rig's known errors.
//!
//! | file | contents |
//! |---|---|
//! | [`interface`] | the interface between loop and rig |
//! | [`command`] | correction of a command for the actuator's gain and offset |
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
