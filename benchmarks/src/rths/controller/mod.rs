//! Controllers, which turn a target into a command.
//!
//! # To enter your own controller
//! In your own crate: `benchmarks/examples/your_controller.rs` is one complete file. To appear in the command's table, put
//! one file into this folder whose type implements [`Controller`], and one entry into [`OUTSIDE`]; `benchmark rths
//! --controllers NAME` gives its row. You need to know nothing else about this project: the floors' displacements and two
//! readings come in, and a command goes out, 4096 times a second. A controller that cannot be written in Rust can be judged
//! by a table of its commands, see `--follow`.

mod baseline;
mod core_method;
mod entry;
mod fixed_inverse;
pub(super) mod interface;
mod outside;

pub use core_method::CoreLoops;
pub use entry::Contestant;
pub use interface::{Controller, ControllerInput, DeclaredPlant};
pub use outside::{OUTSIDE, Outside};
