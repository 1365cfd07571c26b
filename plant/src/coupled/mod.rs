//! Two actuators on one coupler, which move a specimen in x and in rotation.
//!
//! ```text
//!  two commands ─► delay ─► 2 x 2 transfer function ─► strokes ─► coupler ─► x, rotation ─► specimen
//!                                                       │                                      │
//!                                                    sensors ─► Reading ◄─ sensors ◄─ forces of the actuators
//! ```
//!
//! | look in | for |
//! |---|---|
//! | [`CoupledRig`] | the composition; [`CoupledRigSpec`] is the table `[plant.coupled]` of a test file |
//! | [`ActuatorPair`] | commands to strokes, cross terms included |
//! | [`CouplerSpec`] | strokes to x and rotation and back, forces to force and moment: exact at any rotation below a right angle |
//! | [`CoupledSpecimen`] | mass, damping and stiffness for x and rotation, and springs that yield |
//!
//! Cross terms are those of the actuators under the specimen that they hold, as a measured transfer function has them:
//! a specimen that is changed does not change them.

mod actuators;
mod coupler;
mod rig;
mod specimen;

pub use actuators::{ActuatorPair, ActuatorPairSpec};
pub use coupler::CouplerSpec;
pub use rig::{CoupledReading, CoupledRig, CoupledRigSpec};
pub use specimen::{CoupledSpecimen, CoupledSpecimenSpec, SpringSpec};

/// A value for each actuator, or for x and rotation.
pub type Pair = [f64; 2];

use crate::error::RigError;

/// That `value` is finite and in `range`.
fn within(
    path: String,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    accepted: &str,
) -> Result<(), RigError> {
    if range.contains(&value) {
        Ok(())
    } else {
        Err(RigError::new(path, value, accepted))
    }
}
