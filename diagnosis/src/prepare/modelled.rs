//! A model's response to records.

use crate::model::base::Base;
use crate::numbers::signals::end_of;
use crate::prepare::problem::Problem;
use crate::record::recording::Recording;

/// Displacement or force of a channel's model over each record, mm or N; `None` if a signal is missing. `cutoff_hz`
/// separates the displacement from its noise.
pub fn answers(base: &Base, records: &[Recording], cutoff_hz: f64) -> Option<Vec<Vec<f64>>> {
    let problem = Problem::new(base, records, cutoff_hz, &[])?;
    let own = problem.segments.iter().zip(records);
    let judged = own.map(|(s, r)| end_of(&s.signals.base, r.time_s.len()).to_vec());
    Some(judged.collect())
}
