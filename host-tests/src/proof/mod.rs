//! The proof table: the board's commands, what can trip it, and which test proves each of these, and where.
//!
//! Ids come from the code's own lists ([`ids`]). A test claims some of them in the line above it ([`claims`]):
//!
//! ```text
//! // proves: fault.adc_rail by SensorAtRail
//! ```
//!
//! so a removed test takes its claim along. Claims are validated by mutants of the code ([`mutants`]) and by what is made to
//! fail in a test. [`page`] joins them and says what is missing.

pub mod claims;
pub mod ids;
pub mod mutants;
pub mod page;

use std::path::{Path, PathBuf};

/// The folder of the repository.
pub fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
