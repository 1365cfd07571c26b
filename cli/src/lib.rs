//! The PC tool: runs fast pseudodynamic tests, judges them, and shows what happened.
//!
//! | look in | for |
//! |---|---|
//! | [`verb`] | one file per verb of the command line |
//! | [`board`] | the PC's side of a board: link, orders, a test over the serial port |
//! | `document` | sentences, tables and plots, for the terminal and for a page |
//! | `answer` | the result of each verb, as such a document |
//! | `order_recorder` | the operator's requests in a running test, for its replay |
//! | `difference` | two completed tests, side by side |
//! | `many` | a test for many values of a key, or on drawn rigs |
//! | [`archive`] | a test in one file, for its replay |
//! | `designed_test` | a test designed by the diagnosis, as a file |
//! | [`improve`] | a test, the diagnosis of its record, the next test |
//! | `keys` | every key of a test file, from the code that reads it |
//! | [`program`] | the command line, and the exit status |
//! | `provenance` | who ran what, when, with which files |
//! | `wording` | a diagnosis in sentences |
//! | [`site`] | where a test runs: simulated, on a board, on an emulated one |
//! | [`serve`] | the rig as an element of a finite-element model |
//! | `scope` | a picture in the browser while a test runs |
//!
//! Every mistake of the user is an [`experiment::failure::Failure`]: one sentence and an exit status.

/// Prints a line. The standard library's macro panics if standard output cannot be written, for example on a full disk;
/// this one has the same name, so that no line of this crate uses that one by mistake.
macro_rules! println {
    () => { $crate::terminal::output::print_line(format_args!("")) };
    ($($text:tt)*) => { $crate::terminal::output::print_line(format_args!($($text)*)) };
}

/// Prints a line that was requested by name, such as JSON: `--quiet` does not suppress it.
macro_rules! answer {
    ($($text:tt)*) => { $crate::terminal::output::print_answer(format_args!($($text)*)) };
}

/// Prints a line on standard error, or nothing if that cannot be written; the standard library's macro would panic.
macro_rules! eprintln {
    ($($text:tt)*) => { $crate::terminal::output::print_note(format_args!($($text)*)) };
}

mod answer;
pub mod archive;
pub mod board;
mod designed_test;
mod difference;
mod document;
pub mod improve;
mod keys;
mod many;
mod order_recorder;
pub mod program;
mod provenance;
mod scope;
pub mod serve;
pub mod site;
pub mod terminal;
pub mod verb;
mod wording;
