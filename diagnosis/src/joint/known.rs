//! What the model has from before is taken off the records first.

use super::track::UnfilteredSpan;
use crate::base::Base;
use crate::criteria::BAND_ROOM;
use crate::problem::Problem;
use crate::recording::Recording;

/// Records without the force of effects and elements that the model has from before.
pub fn without_known(base: &Base, records: &[Recording]) -> Option<Vec<Recording>> {
    if base.known.is_empty() && base.elements.is_empty() {
        return Some(records.to_vec());
    }
    records
        .iter()
        .map(|r| {
            let force = known_force(base, r)?;
            let measured = r.force_n.as_ref()?;
            Some(Recording {
                force_n: Some(measured.iter().zip(force).map(|(m, f)| m - f).collect()),
                ..r.clone()
            })
        })
        .collect()
}

/// The force of effects and elements that the model has from before, N.
fn known_force(base: &Base, record: &Recording) -> Option<Vec<f64>> {
    let n = record.time_s.len();
    if base.known.is_empty() && base.elements.is_empty() {
        return Some(vec![0.0; n]);
    }
    let bare = Base {
        known: Vec::new(),
        elements: Vec::new(),
        ..base.clone()
    };
    let cutoff_hz = UnfilteredSpan::new(record)?.band_hz() * BAND_ROOM;
    let one = std::slice::from_ref(record);
    let with = Problem::new(base, one, cutoff_hz, &[])?;
    let without = Problem::new(&bare, one, cutoff_hz, &[])?;
    let own = |p: &'_ Problem| {
        let stretch = &p.stretches[0];
        stretch.signals.base[stretch.lead..].to_vec()
    };
    let (with, without) = (own(&with), own(&without));
    let pairs = with.iter().zip(&without);
    Some(pairs.map(|(a, b)| a - b).collect())
}
