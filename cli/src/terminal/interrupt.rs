//! Ctrl-C in long work: what is done is kept.

use std::sync::atomic::{AtomicBool, Ordering};

static ASKED: AtomicBool = AtomicBool::new(false);

/// From now on the first Ctrl-C lets the work end early, and the second ends the program.
pub fn watch() {
    // Where a handler is set already, Ctrl-C does what it says.
    let _ = ctrlc::set_handler(|| {
        if ASKED.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        eprintln!("\nouterloop: ends after the tests that run now; Ctrl-C again ends at once");
    });
}

/// True if the work is to end early.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
