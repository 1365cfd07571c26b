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
pub mod look_ahead;
pub mod measured;
mod missing_rows;
pub mod model;
pub mod near_fault;
mod note;
mod notes;
pub mod output;
mod place;
pub mod plain;
mod quantities;
pub mod record_csv;
pub mod recording;
mod refused;
pub mod serve;
pub mod signal;
pub mod table;
pub mod test;
pub mod third_party;
pub mod units;
pub mod watch;
pub mod witness;

use crate::failure::Failure;
use note::note;
use std::path::Path;

/// Reads a text file in any encoding.
///
/// # Errors
/// A file, with its name, that cannot be read or is not text.
pub fn read(path: &Path) -> Result<String, Failure> {
    decode::text(&path.display().to_string(), decode::bytes(path)?)
}
