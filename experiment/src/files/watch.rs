//! `[watch]` of a test file.

use serde::{Deserialize, Serialize};

/// `[watch]`: whether the running test is watched for what its declared model lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WatchSettings {
    /// Watch the running test: name what the rig does otherwise than declared.
    pub on: bool,
    /// Causes that the loop shall correct for while the test runs: none can be yet, so the list is empty.
    pub correct: Vec<String>,
    /// Largest predicted error at the end of the test: the loop cannot trip on it yet, so it is left out.
    pub trip_eps: Option<f64>,
}

impl Default for WatchSettings {
    fn default() -> Self {
        Self {
            on: true,
            correct: Vec::new(),
            trip_eps: None,
        }
    }
}

impl WatchSettings {
    /// That it asks for nothing that is not done.
    ///
    /// # Errors
    /// A correction or a trip.
    pub fn check(&self) -> Result<(), String> {
        if let Some(name) = self.correct.first() {
            return Err(format!(
                "watch.correct = [\"{name}\"] is refused: accepted is the empty list, since the watch names causes and does not correct \
                 for them"
            ));
        }
        if let Some(eps) = self.trip_eps {
            return Err(format!(
                "watch.trip_eps = {eps} is refused: accepted is to leave it out, since the watch does not trip a test; limits.energy_trip \
                 does"
            ));
        }
        Ok(())
    }
}
