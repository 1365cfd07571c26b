//! The record of a signal: command, displacement and force, step by step, in the format of recorded data.

use crate::failure::Failure;
use crate::files::measured::in_mm;
use crate::files::recording::SiRecording;
use std::fmt::Write as _;

/// A signal that was played.
#[derive(Clone, Debug)]
pub struct Played {
    /// The recording as CSV.
    pub text: String,
    /// Number of steps.
    pub steps: usize,
    /// Why it ended early, if it did.
    pub early: Option<String>,
    /// Largest displacement, m.
    pub peak_m: f64,
    /// Largest force, N.
    pub peak_n: f64,
    /// Force on each of the board's actuators over the displacement of the one that moved, N/m, if it responded.
    pub stiffness_n_per_m: Vec<Option<f64>>,
    /// A suspected wiring error.
    pub suspicion: Option<String>,
}

impl Played {
    /// Why a signal ended early if a person stopped it.
    pub const BY_HAND: &str = "it was stopped by hand";

    /// Why a signal ended early if the board's button stopped it.
    pub const BY_BUTTON: &str = "the board's button ended it";

    /// True if somebody stopped it.
    pub fn is_stopped(&self) -> bool {
        let why = self.early.as_deref();
        why.is_some_and(|why| [Self::BY_HAND, Self::BY_BUTTON].contains(&why))
    }

    /// Without any step.
    pub fn new() -> Self {
        Self {
            text: String::from("time_s,command_m,displacement_m,force_n\n"),
            steps: 0,
            early: None,
            peak_m: 0.0,
            peak_n: 0.0,
            stiffness_n_per_m: Vec::new(),
            suspicion: None,
        }
    }

    /// Adds the next step, without a gap.
    pub fn add(&mut self, rate_hz: f64, command_m: f32, displacement_m: f32, force_n: f32) {
        let time_s = self.steps as f64 / rate_hz;
        self.add_at(time_s, command_m, displacement_m, force_n);
    }

    /// Adds a step at a time, s.
    pub fn add_at(&mut self, time_s: f64, command_m: f32, displacement_m: f32, force_n: f32) {
        let _ = writeln!(self.text, "{time_s},{command_m},{displacement_m},{force_n}");
        self.steps += 1;
        self.peak_m = self.peak_m.max(f64::from(displacement_m.abs()));
        self.peak_n = self.peak_n.max(f64::from(force_n.abs()));
    }

    /// The same, with the reason for an early end.
    pub fn ended_early(self, why: String) -> Self {
        Self {
            early: Some(why),
            ..self
        }
    }

    /// As input for a diagnosis.
    ///
    /// # Errors
    /// A signal that ended before it had a record.
    pub fn recording(&self) -> Result<diagnosis::Recording, Failure> {
        let read = SiRecording::parse("the designed test's record", &self.text)?;
        in_mm(&read, 0..read.time_s.len())
            .made_even()
            .map_err(Failure::test)
    }
}

impl Default for Played {
    fn default() -> Self {
        Self::new()
    }
}
