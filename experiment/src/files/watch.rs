//! `[watch]` of a test file.

use outerloop_core::watch::Corrections;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `[watch]`: whether the running test is watched for what its declared model lacks, and what the watch may do about it. A test of
/// `serve` or of `[coupled]` is not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct WatchSettings {
    /// Watch the running test: name what the rig does otherwise than declared, and stop the test where a sensor is seen to stand
    /// still: a displacement with `[declared.actuator]`, a force in a structure of one floor.
    pub on: bool,
    /// Hold what an adaptive compensation has learnt at what was declared while the displacement transducer is among the causes.
    pub guard: bool,
    /// What the loop corrects for once a set has settled that is one cause or the actuator's alone: `lateness` and `gain` of the
    /// actuator, `late_sensor`.
    pub correct: Vec<String>,
    /// Largest error, rms and of the planned peak, that what is named may be predicted to add by the end of the test; beyond, the
    /// test is stopped. Left out: it is not predicted.
    pub trip_eps: Option<f64>,
}

impl Default for WatchSettings {
    fn default() -> Self {
        Self {
            on: true,
            guard: true,
            correct: Vec::new(),
            trip_eps: None,
        }
    }
}

impl WatchSettings {
    /// Checks that it requests nothing that is not available.
    ///
    /// # Errors
    /// An unknown correction; an inadmissible limit; a request to a watch that is off.
    pub fn check(&self) -> Result<(), String> {
        self.corrections()?;
        if let Some(eps) = self.trip_eps.filter(|eps| !(1e-4..=10.0).contains(eps)) {
            return Err(format!(
                "watch.trip_eps = {eps} is refused: accepted are shares of the planned peak, 0.0001 to 10"
            ));
        }
        let asks = !self.correct.is_empty() || self.trip_eps.is_some();
        if asks && !self.on {
            return Err(
                "watch.on = false is refused beside watch.correct or watch.trip_eps: accepted is true, since only what is \
                 watched can be corrected or stopped"
                    .to_owned(),
            );
        }
        Ok(())
    }

    /// Checks that it requests nothing of the loop, which `place` does not support.
    ///
    /// # Errors
    /// A correction or a limit.
    pub fn only_looks(&self, place: &str) -> Result<(), String> {
        if !self.correct.is_empty() {
            return Err(format!(
                "watch.correct = {:?} is refused {place}: accepted there is the empty list, and any of them in a test of `run`",
                self.correct
            ));
        }
        match self.trip_eps {
            None => Ok(()),
            Some(eps) => Err(format!(
                "watch.trip_eps = {eps} is refused {place}: accepted there is to leave it out, and a limit in a test of `run`"
            )),
        }
    }

    /// The permitted corrections.
    ///
    /// # Errors
    /// A name that is none of them.
    pub fn corrections(&self) -> Result<Corrections, String> {
        let mut all = Corrections::default();
        for name in &self.correct {
            match name.as_str() {
                "lateness" => all.lateness = true,
                "gain" => all.gain = true,
                "late_sensor" => all.late_sensor = true,
                other => {
                    return Err(format!(
                        "watch.correct: `{other}` is unknown: accepted are lateness, gain, late_sensor"
                    ));
                }
            }
        }
        Ok(all)
    }
}
