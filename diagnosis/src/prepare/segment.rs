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
    /// Samples that are not judged: around corners of the motion, where the force between two samples is unknown.
    pub corners: Vec<usize>,
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
        self.without_corners(self.seen(x).to_vec())
    }

    /// Removes the samples that are not judged from the considered part of a signal.
    pub fn without_corners(&self, seen: Vec<f64>) -> Vec<f64> {
        self.without(&self.corners, self.measured(seen))
    }

    /// Removes the unmeasured samples from the considered part of a signal.
    pub fn measured(&self, seen: Vec<f64>) -> Vec<f64> {
        self.without(&self.unmeasured, seen)
    }

    fn without(&self, samples: &[usize], mut seen: Vec<f64>) -> Vec<f64> {
        let seen_samples = samples.iter().filter_map(|i| i.checked_sub(self.from));
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

/// A corner: over 3 samples to either side the acceleration changes by more than this fraction of its rms. Commands to
/// a rig change it by a few percent.
const CORNER: f64 = 0.3;
/// If corners exceed this fraction of the samples, they are the motion itself.
const MOSTLY: f64 = 0.2;

/// Samples around the corners of a motion without noise.
pub fn corners(a: &[f64]) -> Vec<usize> {
    let n = a.len();
    let most = CORNER * (a.iter().map(|a| a * a).sum::<f64>() / n as f64).sqrt();
    let turns = |i: &usize| (a[*i] - 0.5 * (a[i - 3] + a[i + 3])).abs() > most;
    let mut near: Vec<usize> = (3..n.saturating_sub(3))
        .filter(turns)
        .flat_map(|i| i - 2..i + 3)
        .collect();
    near.dedup();
    if near.len() as f64 > MOSTLY * n as f64 {
        near.clear();
    }
    near
}
