//! A table of numbers from any kind of file.

use super::table::NumberTable;
use super::{binary, decode};
use crate::failure::Failure;
use std::path::Path;

/// Reads a file: text in any dialect, with its bad cells, MAT or HDF5. `by_number`: the columns of a text without a
/// header are called 1, 2, ...
///
/// # Errors
/// A file that cannot be read, or that contains no table of numbers.
pub fn read(path: &Path, by_number: bool) -> Result<NumberTable, Failure> {
    let (file, bytes) = (path.display().to_string(), decode::bytes(path)?);
    if binary::is_binary(&bytes) {
        binary::parse(&file, bytes)
    } else {
        let text = decode::text(&file, bytes)?;
        NumberTable::parse_with_bad_cells(&file, &text, by_number)
    }
}
