//! The flashed image, unmodified, on an emulated board with the simulated rig behind its converters.
#![allow(missing_docs)]

mod crashes;
mod desk;
mod limits_and_link;
mod mutants;
mod settings;
mod whole_test;
