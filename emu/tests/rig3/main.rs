//! The image for three actuators, unmodified, on an emulated board with models of an AD7606 and an AD5754R on its serial
//! interfaces and a rig of three storeys: its own mutants, what only it has, and the examples with three and with two coupled
//! actuators.
#![allow(missing_docs)]

use outerloop_cli::board::Image;

/// The image of these tests.
const IMAGE: Image = Image::Three;

mod actuators;
mod converters;
mod coupled;
#[path = "../rig/desk.rs"]
#[expect(dead_code, reason = "what only the scenarios with one actuator use")]
mod desk;
#[path = "../common/example.rs"]
mod example;
#[path = "../common/load.rs"]
mod load;
#[path = "../rig/mutant.rs"]
mod mutant;
mod mutants;
#[path = "../rig/priorities.rs"]
mod priorities;
#[path = "../rig16/silent.rs"]
mod silent;
mod three_storey;
