//! Controllers: what turns a target into a command.
//!
//! # To enter a controller of your own
//! In a crate of your own: `benchmarks/examples/your_controller.rs` is one file that runs. To be in the command's table, put
//! one file into this folder whose type implements [`Controller`], and one line into [`OUTSIDE`]; `benchmark rths
//! --controllers NAME` gives its row. Nothing else has to be known of this project: a target and two readings come in, a
//! command goes out, 4096 times a second. A controller that cannot be written in Rust can be judged by a table of its
//! commands, see `--follow`.

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
