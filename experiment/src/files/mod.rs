//! Files that people write and read: tests, ground motions, recorded data, results.

pub mod any_table;
pub mod binary;
mod cell;
pub mod channels;
pub mod columns;
pub mod coupled;
pub mod decode;
pub mod dialect;
pub mod ground_motion;
pub mod header;
mod labview;
pub mod measured;
pub mod model;
pub mod near_fault;
mod notes;
pub mod output;
pub mod plain;
mod quantities;
pub mod record_csv;
pub mod recording;
mod refused;
pub mod serve;
pub mod signal;
pub mod table;
pub mod test;
pub mod units;

use crate::failure::Failure;
use std::fmt::Arguments;
use std::io::{Write, stderr};
use std::path::Path;

/// Reads a text file, whatever its encoding is.
///
/// # Errors
/// A file that cannot be read or is no text, by its name.
pub fn read(path: &Path) -> Result<String, Failure> {
    decode::text(&path.display().to_string(), decode::bytes(path)?)
}

/// Says on standard error what a reader should know of a file, or nothing where that cannot be written: nobody is left to read it.
fn note(text: Arguments<'_>) {
    let _ = stderr().write_all(format!("outerloop: note: {text}\n").as_bytes());
}
