//! A test that the diagnosis has designed, as a file that `run` plays.

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

/// A designed test as a file.
pub fn text(next: &diagnosis::Next) -> String {
    let mut text = format!(
        "# {}\n# {}\ntime_s,command_mm\n",
        plan::summary(next),
        plan::limits(next)
    );
    for (t, x) in next.time_s().iter().zip(&next.command_mm) {
        let _ = writeln!(text, "{t:.6},{x:.6}");
    }
    text
}
