//! The PC tool: runs fast pseudodynamic tests, judges them, and shows what happened.
//!
//! | look in | for |
//! |---|---|
//! | [`verb`] | one file a verb of the command line |
//! | [`board`] | the PC's side of a board: link, orders, a test over the serial port |
//! | `document` | sentences, tables and plots, for the terminal and for a page |
//! | `answer` | what each verb answers, as such a document |
//! | `order_recorder` | what an operator asked of a running test, for its replay |
//! | `difference` | two tests that ran, side by side |
//! | `many` | a test over the values of one key, or on drawn rigs |
//! | [`archive`] | what a test leaves in its folder, for its replay |
//! | `designed_test` | a test that the diagnosis has designed, as a file |
//! | [`improve`] | a test, the diagnosis of its record, the next test |
//! | `keys` | every key of a test file, from the code that reads it |
//! | [`program`] | the command line, and what the program returns |
//! | `provenance` | who ran what, when, with which files |
//! | `wording` | what a diagnosis says, in sentences |
//! | [`site`] | where a test runs: simulated, on a board, on an emulated one |
//! | [`serve`] | the rig as an element of a finite-element model |
//! | `scope` | a picture in the browser while a test runs |
//!
//! Every mistake of the user is an [`experiment::failure::Failure`]: one sentence and an exit status.

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
