//! The equations of what a rig may contain: elements of a specimen over its motion, parts of an actuator's path, and
//! the library of effects for model files.

pub mod drivetrain;
pub mod library;
pub mod specimen;
