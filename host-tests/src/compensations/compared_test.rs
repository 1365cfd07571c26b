//! One test of a comparison.

use super::condition::Family;
use experiment::summary::Summary;
use serde::Serialize;

/// One test of the bench.
#[derive(Clone, Debug, Serialize)]
pub struct ComparedTest {
    /// What kind of rig.
    pub family: Family,
    /// The rig in words.
    pub condition: String,
    /// Its delay on a slow motion, ms.
    pub delay_ms: f64,
    /// The figures of the test.
    #[serde(flatten)]
    pub summary: Summary,
}

impl ComparedTest {
    /// eps_rms; 1, an error as large as the motion, if the test tripped or ran away.
    pub fn error(&self) -> f64 {
        match self.summary.verdict {
            experiment::summary::TestVerdict::Completed if self.summary.eps_rms < 1.0 => {
                self.summary.eps_rms
            }
            _ => 1.0,
        }
    }
}
