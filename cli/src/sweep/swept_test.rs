//! One test of a sweep.

use experiment::summary::{Summary, TestVerdict};
use serde::Serialize;

/// One test of a sweep.
#[derive(Clone, Debug, Serialize)]
pub struct SweptTest {
    /// Value of the key.
    pub value: f64,
    /// Largest displacement of any floor on an ideal rig, m.
    pub ideal_peak_m: f64,
    /// The test.
    #[serde(flatten)]
    pub summary: Summary,
}

impl SweptTest {
    /// The displacement went beyond `limit_m`; what tripped or ran away did, wherever that was.
    pub fn beyond(&self, limit_m: f64) -> bool {
        self.summary.verdict != TestVerdict::Completed || self.summary.peak_displacement_m > limit_m
    }
}
