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
//! Cross terms belong to the actuators with the specimen that they hold, as in a measured transfer function: changing
//! the specimen does not change them.

mod actuators;
mod coupler;
mod pair;
mod rig;
mod specimen;

pub use actuators::{ActuatorPair, ActuatorPairSpec};
pub use coupler::CouplerSpec;
pub use pair::Pair;
pub use rig::{CoupledReading, CoupledRig, CoupledRigSpec};
pub use specimen::{CoupledSpecimen, CoupledSpecimenSpec, SpringSpec};
