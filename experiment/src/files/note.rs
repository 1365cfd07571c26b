//! Notes on standard error.

use std::fmt::Arguments;
use std::io::{Write, stderr};

/// Writes a reader's note on a file to standard error, or nothing if that fails: nobody is left to read it.
pub(super) fn note(text: Arguments<'_>) {
    let _ = stderr().write_all(format!("outerloop: note: {text}\n").as_bytes());
}
