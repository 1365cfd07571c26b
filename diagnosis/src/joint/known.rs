//! What the model has from before is taken off the records first.

use super::track::UnfilteredSpan;
use crate::base::Base;
use crate::criteria::BAND_ROOM;
use crate::problem::Problem;
use crate::recording::Recording;
use crate::signals::difference;

/// Records without the force of effects and elements that the model has from before.
pub fn without_known(base: &Base, records: &[Recording]) -> Option<Vec<Recording>> {
    if base.known.is_empty() && base.elements.is_empty() {
        return Some(records.to_vec());
    }
    records
        .iter()
        .map(|r| {
            let force = difference(r.force_n.as_ref()?, &known_force(base, r)?);
            Some(Recording {
                force_n: Some(force),
                ..r.clone()
            })
        })
        .collect()
}

/// The force of effects and elements that the model has from before, N.
fn known_force(base: &Base, record: &Recording) -> Option<Vec<f64>> {
    let bare = Base {
        known: Vec::new(),
        elements: Vec::new(),
        ..base.clone()
    };
    let cutoff_hz = UnfilteredSpan::new(record)?.band_hz() * BAND_ROOM;
    let one = std::slice::from_ref(record);
    let answer = |base| {
        let segment = Problem::new(base, one, cutoff_hz, &[])?
            .segments
            .swap_remove(0);
        Some(segment.signals.base[segment.lead..].to_vec())
    };
    Some(difference(&answer(base)?, &answer(&bare)?))
}
