//! The specimen's motion as a model of the actuator tells it.

use crate::base::Base;
use crate::fit::Solution;
use crate::problem::Problem;
use crate::recording::Recording;
use crate::signals::{difference, peak, rms};
use crate::spectrum;

/// The actuator, where it is explained down to its noise.
#[derive(Debug)]
pub struct KnownActuator {
    /// Its declared model.
    pub base: Base,
    /// Where its displacement ends and noise begins, Hz.
    pub cutoff_hz: f64,
    /// What explains it.
    pub solution: Solution,
}

impl KnownActuator {
    /// Whether it tells the motion of these records better than a low-pass of the readings does.
    pub fn tells(&self, records: &[Recording]) -> bool {
        records.iter().all(|r| {
            let steady = |x: Vec<f64>| !spectrum::jitters(&x, r.interval_s(), self.cutoff_hz);
            self.motion(r).is_some_and(steady)
        })
    }

    /// The displacement without noise, mm, and with corners that no low-pass of a reading leaves, from what the file holds
    /// before the record on; none where that begins in motion, since what was commanded before is not in it.
    pub fn motion(&self, r: &Recording) -> Option<Vec<f64>> {
        let s = &self.solution;
        let mut problem = Problem::new(&self.base, std::slice::from_ref(r), self.cutoff_hz, &[])?;
        problem.scales = s.problem.scales;
        problem.set(&self.base, s.problem.theta);
        let segment = problem.segments.first()?;
        let motion = problem.answer(segment, &s.effects, &s.problem.scales);
        let reading = r.displacement_mm.as_ref()?;
        begins_alike(&motion[segment.lead..], reading, r.interval_s()).then_some(motion)
    }
}

/// How long a command acts on an actuator, s.
const MEMORY_S: f64 = 0.25;

/// Whether a modelled motion is like its reading from the first sample on: a record that begins in mid-motion does not
/// tell the commands before it, and the corner where they are missed would be an acceleration that never was.
fn begins_alike(motion: &[f64], reading: &[f64], interval_s: f64) -> bool {
    let differences = difference(motion, reading);
    let start = ((MEMORY_S / interval_s) as usize).min(differences.len() / 4);
    let (first, others) = differences.split_at(start);
    let largest = peak(first);
    largest <= 6.0 * rms(&[others.to_vec()])
}
