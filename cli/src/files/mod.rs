//! Files that people write and read: tests, ground motions, recorded data, results.

pub mod ground_motion;
pub mod measured;
pub mod model;
pub mod near_fault;
pub mod output;
pub mod record_csv;
pub mod recording;
pub mod table;
pub mod test;

use crate::failure::Failure;
use std::path::Path;

/// Reads a text file.
///
/// # Errors
/// A file that cannot be read, by its name.
pub fn read(path: &Path) -> Result<String, Failure> {
    std::fs::read_to_string(path)
        .map_err(|e| Failure::input(format!("{}: cannot be read: {e}", path.display())))
}
