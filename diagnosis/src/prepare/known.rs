//! Removes the contribution of effects that the model already has from the records.

use crate::criteria::BAND_ROOM;
use crate::laws::specimen::track::UnfilteredSpan;
use crate::model::base::Base;
use crate::numbers::signals::difference;
use crate::prepare::problem::Problem;
use crate::record::recording::Recording;
use crate::record::spectrum::low_passed;
use plant::{Effect, Family};

/// Records without the force of effects and elements that the model already has.
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

/// Multiple of the motion's band that is kept if noise above it would be turned into a force.
const KEPT_BANDS: f64 = 1.5;

/// True if a known effect turns displacement noise into force: one with a rate, or with both edges of a gap.
fn acts_on_steps(base: &Base) -> bool {
    let feels = |e: Effect| e == Effect::ChannelSkew || e.entry().family == Family::Gap;
    base.known.iter().any(|e| feels(e.name))
}

/// The record without the displacement noise above a cut-off.
fn of_smoothed_motion(record: &Recording, cutoff_hz: f64) -> Recording {
    let interval_s = record.interval_s();
    let smoothed = |x: &Vec<f64>| low_passed(x, interval_s, cutoff_hz);
    Recording {
        displacement_mm: record.displacement_mm.as_ref().map(smoothed),
        ..record.clone()
    }
}

/// The force of effects and elements that the model already has, N.
fn known_force(base: &Base, record: &Recording) -> Option<Vec<f64>> {
    let bare = Base {
        known: Vec::new(),
        elements: Vec::new(),
        ..base.clone()
    };
    let band_hz = UnfilteredSpan::new(record)?.band_hz();
    let cutoff_hz = band_hz * BAND_ROOM;
    let smoothed = acts_on_steps(base).then(|| of_smoothed_motion(record, KEPT_BANDS * band_hz));
    let one = std::slice::from_ref(smoothed.as_ref().unwrap_or(record));
    let answer = |base| {
        let segment = Problem::new(base, one, cutoff_hz, &[])?
            .segments
            .swap_remove(0);
        Some(segment.signals.base[segment.lead..].to_vec())
    };
    Some(difference(&answer(base)?, &answer(&bare)?))
}
