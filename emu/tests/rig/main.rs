//! The flashed image, unmodified, on an emulated board with the simulated rig behind its converters.
#![allow(missing_docs)]

use outerloop_cli::board::Image;

/// The image of these tests.
const IMAGE: Image = Image::Internal;

mod commissioning;
mod crashes;
mod desk;
mod inputs;
mod limits_and_link;
mod modes;
mod monitor;
mod mutant;
mod mutants;
mod orders;
mod priorities;
mod reset_lines;
mod reused;
mod settings;
mod stopped;
mod whole_test;
