//! A record as a channel sees it, and which of its samples are judged.

use crate::model::base::Base;
use crate::numbers::signals::Signals;
use crate::record::recording::{Recording, begins_at_rest};
use plant::Channel;

/// A record as a channel sees it.
#[derive(Clone, Debug)]
pub struct Segment {
    /// Input to the effects; `base` belongs to the present parameters.
    pub signals: Signals,
    /// The measured output.
    pub target: Vec<f64>,
    /// Unmeasured samples: no residual is formed there.
    pub unmeasured: Vec<usize>,
    /// Number of samples before the record, taken from the file, so that the model begins in the rig's state.
    pub lead: usize,
    /// First sample of the record that is considered: before it the model forgets its start.
    pub from: usize,
}

impl Segment {
    /// The part of a signal that is considered.
    pub fn seen<'x>(&self, x: &'x [f64]) -> &'x [f64] {
        &x[self.from..]
    }

    /// That part without the samples that are not judged.
    pub fn judged(&self, x: &[f64]) -> Vec<f64> {
        self.measured(self.seen(x).to_vec())
    }

    /// Removes the unmeasured samples from the considered part of a signal.
    pub fn measured(&self, mut seen: Vec<f64>) -> Vec<f64> {
        let unmeasured = self.unmeasured.iter();
        let seen_samples = unmeasured.filter_map(|i| i.checked_sub(self.from));
        seen_samples.for_each(|i| seen[i] = 0.0);
        seen
    }
}

/// Largest fraction of a record that may only settle the model.
const MOST_SETTLING: f64 = 0.05;

/// Number of samples of an actuator's record that are skipped because an earlier command still acts: it begins in
/// mid-motion, and only the last `lead` samples before it are known.
pub fn settling(base: &Base, record: &Recording, lead: usize) -> usize {
    let command = record.command_mm.as_ref();
    if base.channel == Channel::Specimen || command.is_none_or(|u| begins_at_rest(u)) {
        return 0;
    }
    let whole = (base.settling_s() / record.interval_s()) as usize;
    let most = (MOST_SETTLING * record.time_s.len() as f64) as usize;
    whole.saturating_sub(lead).min(most)
}
