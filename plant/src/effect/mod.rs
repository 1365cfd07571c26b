//! Effects that a declared model may lack, by the names used in the diagnosis' answers.
//!
//! Any of them can be added to any rig, any number of times: `plant.effects = [{ name = "coulomb_friction", force_n = 20 }]`.
//! [`catalogue`] has the physics, channels and parameters of each; an effect in the `actuator` channel shows between
//! command and displacement, one in the `specimen` channel between displacement and force.

mod adding;
pub(crate) mod additions;
mod by_axis;
mod catalogue;
mod given;
mod row;
mod spec;

pub(crate) use additions::{Additions, ChannelAdditions};
pub(crate) use by_axis::{Later, additions};
pub use catalogue::{Effect, Entry, catalogue};
pub use row::{Channel, Family, Parameter};
pub use spec::{EffectSpec, Sensor};
