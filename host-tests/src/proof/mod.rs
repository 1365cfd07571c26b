//! The proof table: what the board can be asked, what can trip it, and which test proves each of it, where.
//!
//! Ids come from the code's own lists ([`ids`]). A test claims some of them in the line above it ([`claims`]):
//!
//! ```text
//! // proves: fault.adc_rail by SensorAtRail
//! ```
//!
//! so a test that goes takes its claim along. What a claim is worth is shown by mutants of the code ([`mutants`]) and by
//! what is made to fail in a test. [`page`] joins them and says where something is missing.

pub mod claims;
pub mod ids;
pub mod mutants;
pub mod page;

use std::path::{Path, PathBuf};

/// The folder of the repository.
pub fn top() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}
