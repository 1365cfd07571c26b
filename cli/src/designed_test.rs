//! A test designed by the diagnosis, as a file that `run` plays.

use crate::wording::plan;
use experiment::failure::Failure;
use experiment::files::output;
use std::fmt::Write as _;
use std::path::Path;

/// Writes a designed test.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, next: &diagnosis::Next) -> Result<(), Failure> {
    output::write(path, text(next))
}

/// The header line.
const HEAD: &str = "time_s,command_mm";

/// True if a text is a designed test, or a signal with the same two columns: nothing in it was measured.
pub fn is_designed(text: &str) -> bool {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.next() == Some(HEAD)
}

/// A designed test as a file.
pub fn text(next: &diagnosis::Next) -> String {
    let mut text = format!(
        "# {}\n# {}\n{HEAD}\n",
        plan::summary(next),
        plan::limits(next)
    );
    for (t, x) in next.time_s().iter().zip(&next.command_mm) {
        let _ = writeln!(text, "{t:.6},{x:.6}");
    }
    text
}
