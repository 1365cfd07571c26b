//! What may be in a rig, as equations: elements of a specimen over its motion, parts of an actuator's path, and the library of effects
//! that a model file has.

pub mod drivetrain;
pub mod library;
pub mod specimen;
