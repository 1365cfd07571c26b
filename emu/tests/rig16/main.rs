//! The image for external converters of 16 bits, unmodified, on an emulated board with models of both chips on its serial
//! interfaces: the scenarios of the other image, its own mutants, and what only it has.
#![allow(missing_docs)]

use outerloop_cli::board::Image;

/// The image of these tests.
const IMAGE: Image = Image::External;

mod bit_flips;
#[path = "../rig/commissioning.rs"]
mod commissioning;
mod converters;
#[path = "../rig/crashes.rs"]
mod crashes;
#[path = "../rig/desk.rs"]
mod desk;
mod further_faults;
#[path = "../rig/inputs.rs"]
mod inputs;
#[path = "../rig/limits_and_link.rs"]
mod limits_and_link;
#[path = "../rig/mutant.rs"]
mod mutant;
mod mutants;
#[path = "../rig/priorities.rs"]
mod priorities;
mod silent;
mod single_faults;
mod soak;
#[path = "../rig/stopped.rs"]
mod stopped;
mod stroke;
#[path = "../rig/whole_test.rs"]
mod whole_test;
