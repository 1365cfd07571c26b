//! Standard output that may fail: a full disk or a closed pipe is one sentence at the end, never a panic.
//!
//! A test that moves a rig must not be ended by a full disk under its log. So what cannot be printed is dropped, and
//! [`failure`] returns it when the verb has finished.

use crate::failure::Failure;
use crate::files::plain;
use std::fmt::Arguments;
use std::io::{Write, stderr, stdout};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

/// Why standard output could not be written, the first time.
static BROKEN: OnceLock<String> = OnceLock::new();

/// Tables, sentences and progress are switched off.
static QUIET: AtomicBool = AtomicBool::new(false);

/// From now on only what was asked for by name and what goes wrong is printed.
pub fn be_quiet() {
    QUIET.store(true, Ordering::Relaxed);
}

/// Tables, sentences and progress are switched off.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// What `println!` is in this crate.
pub fn print_line(text: Arguments<'_>) {
    if !is_quiet() {
        print_answer(text);
    }
}

/// A line on standard error; dropped where that cannot be written, since nobody is left to read it.
pub fn print_note(text: Arguments<'_>) {
    let mut out = stderr().lock();
    let _ = out.write_fmt(text).and_then(|()| out.write_all(b"\n"));
}

/// What `answer!` is in this crate.
pub fn print_answer(text: Arguments<'_>) {
    if BROKEN.get().is_some() {
        return;
    }
    let mut out = stdout().lock();
    if let Err(e) = out.write_fmt(text).and_then(|()| out.write_all(b"\n")) {
        let _ = BROKEN.set(plain::reason(&e));
    }
}

/// What standard output could not take, once everything is said.
///
/// # Errors
/// A standard output that cannot be written.
pub fn finish() -> Result<(), Failure> {
    if let Err(e) = stdout().flush() {
        let _ = BROKEN.set(plain::reason(&e));
    }
    match BROKEN.get() {
        None => Ok(()),
        Some(why) => Err(Failure::input(format!(
            "standard output cannot be written: {why}; what was printed is not complete"
        ))),
    }
}
