//! Notes on standard error.

use std::fmt::Arguments;
use std::io::{Write, stderr};

/// Says on standard error what a reader should know of a file, or nothing where that cannot be written: nobody is left to read it.
pub(super) fn note(text: Arguments<'_>) {
    let _ = stderr().write_all(format!("outerloop: note: {text}\n").as_bytes());
}
