//! The PC tool: runs fast pseudodynamic tests, judges them, and shows what happened.
//!
//! | look in | for |
//! |---|---|
//! | [`verb`] | one file a verb of the command line |
//! | [`files`] | what people write and read: tests, ground motions, recorded data |
//! | [`experiment`] | a test on a ground motion, and the ideal that it is compared with |
//! | `bench` | where a test runs: one trait, whatever stands behind it |
//! | [`board`] | the PC's side of a board: link, orders, a test over the serial port |
//! | [`trace`] and `score` | what a test leaves, and Eqs 17 and 18 while it runs |
//! | [`summary`] | the figures and the verdict |
//! | `comparison` | one bench for every compensation |
//! | [`coupled`](mod@coupled) | tests of two coupled actuators: file, trial, record, figures |
//! | `orders` | what an operator asked of a running test, for its replay |
//! | `difference` | two tests that ran, side by side |
//! | `sweep` | a test over the values of one key, and fragility curves |
//! | [`soundness`] | if a test may be run: eigenvalues, and the planned motion on the simulated rig |
//! | [`stability`] | if a test can be stable, by the eigenvalues of its loop |
//! | [`improve`] | a test, the diagnosis of its record, the next test |
//! | `rig` | by what a rig departs from an ideal one: simulated, declared, found, taken out |
//! | `keys` | every key of a test file, from the code that reads it |
//! | `memory` | what a test takes of this machine's memory |
//! | `numbers` | numbers for people: three digits and SI prefixes |
//! | `provenance` | who ran what, when, with which files |
//! | `wording` | what a diagnosis says, in sentences |
//! | `physical_part` | what the multi-axial problem declares physical, and what its record says of it |
//! | [`serve`] | the rig as an element of a finite-element model |
//! | `scope` | a picture in the browser while a test runs |
//! | `report` | the self-contained HTML page |
//!
//! Every mistake of the user is a [`failure::Failure`]: one sentence and an exit status.

/// Prints a line. That of the standard library panics where standard output cannot be written, for example on a full
/// disk; this one has the name, so that no line of this crate forgets it.
macro_rules! println {
    () => { $crate::terminal::output::print_line(format_args!("")) };
    ($($text:tt)*) => { $crate::terminal::output::print_line(format_args!($($text)*)) };
}

/// Prints a line that was asked for by name, such as JSON: `--quiet` leaves it.
macro_rules! answer {
    ($($text:tt)*) => { $crate::terminal::output::print_answer(format_args!($($text)*)) };
}

/// Prints a line on standard error, or nothing where that cannot be written; the standard library's panics there.
macro_rules! eprintln {
    ($($text:tt)*) => { $crate::terminal::output::print_note(format_args!($($text)*)) };
}

mod bench;
pub mod board;
mod comparison;
pub mod coupled;
mod difference;
pub mod experiment;
pub mod failure;
pub mod files;
pub mod improve;
pub mod judged;
mod keys;
mod memory;
mod numbers;
mod orders;
mod physical_part;
mod provenance;
mod report;
mod rig;
mod scope;
mod score;
pub mod serve;
pub mod soundness;
pub mod stability;
pub mod summary;
mod sweep;
pub mod terminal;
pub mod trace;
pub mod verb;
mod wording;
