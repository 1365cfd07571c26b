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

pub use core_method::CoreLoops;
pub use entry::Contestant;

use super::FLOORS;
use super::case::Case;
use super::parameters::Parameters;

/// What a controller gets to see at a sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Floors of the numerical part at this sample, m; the first is the target of the specimen.
    pub floors_m: [f64; FLOORS],
    /// Displacement of the specimen at this sample as it was read, noise and all, m.
    pub displacement_m: f64,
    /// Force of the specimen at this sample as it was read, N.
    pub force_n: f64,
}

/// A controller on trial, at rest when it is made.
pub trait Controller: Send {
    /// One sample; the command is held until the next, m.
    fn command_m(&mut self, seen: &Seen) -> f64;

    /// What the controller believes the displacement of this sample to be, m. Officially nobody is judged by it; it is
    /// used where the rules deviate so.
    fn estimate_m(&self) -> Option<f64> {
        None
    }
}

/// What a controller is told before the test. The drawn plant is nobody's to know.
#[derive(Clone, Copy, Debug)]
pub struct Declared {
    /// The structure.
    pub case: Case,
    /// The plant as it is declared.
    pub plant: Parameters,
}

/// A controller that is not one of core's methods.
pub struct Outside {
    /// Its name.
    pub name: &'static str,
    /// What it is told.
    pub told: &'static str,
    /// Makes one, at rest.
    pub make: fn(&Declared) -> Box<dyn Controller>,
}

/// All that are not core's.
pub const OUTSIDE: [Outside; 2] = [
    Outside {
        name: "pi-phase-lead",
        told: "tuned by hand, published",
        make: baseline::make,
    },
    Outside {
        name: "fixed-inverse",
        told: "plant",
        make: fixed_inverse::make,
    },
];
