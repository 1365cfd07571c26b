//! Where displacement ends and noise begins, as the force says: velocities and accelerations above it only disturb.

use super::blocks::{Blocks, Term};
use super::set::{DECLARED, column, declared_columns};
use super::track::{Sizes, Source, Track};
use super::{element::Element, element::Law};
use crate::criteria::{BAND_ROOM, CUTOFF_ROOM, CUTOFFS};
use crate::linear::Bound;
use rayon::prelude::*;

/// The lowest cut-off of a ladder whose cross-validated squares are within a few percent of the best; never inside the
/// band of any span.
pub fn choose(train: &[Source], test: &[Source], found: Option<&[Element]>) -> Option<f64> {
    let band = |s: &[Source]| s.iter().map(Source::band_hz).fold(0.0, f64::max);
    let (own, other) = (band(train), band(test));
    let half_rate = 0.5 / train[0].interval_s();
    let lowest = (BAND_ROOM * own.max(other)).min(half_rate);
    let step = (half_rate / lowest).powf(1.0 / (CUTOFFS - 1) as f64);
    let ladder: Vec<f64> = (0..CUTOFFS).map(|i| lowest * step.powi(i as i32)).collect();
    let judged: Vec<(f64, f64)> = ladder
        .par_iter()
        .filter_map(|&hz| {
            let hz_used = if hz > 0.99 * half_rate {
                f64::INFINITY
            } else {
                hz
            };
            let tracks: Vec<Track> = train.iter().map(|s| s.track(hz_used)).collect();
            Some((hz, squares(&tracks, found)?))
        })
        .collect();
    let best = judged.iter().map(|j| j.1).fold(f64::INFINITY, f64::min);
    judged
        .into_iter()
        .find(|j| j.1 <= CUTOFF_ROOM * best)
        .map(|j| j.0)
}

/// Cross-validated squares of a model of everyday columns, or of elements that were found.
fn squares(tracks: &[Track], found: Option<&[Element]>) -> Option<f64> {
    let sizes = Sizes::of(tracks);
    let everyday = [
        Element::new(Law::Saturating, [0.05 * sizes.v]),
        Element::new(Law::Slider, [0.01 * sizes.x]),
        Element::new(Law::Slider, [0.1 * sizes.x]),
        Element::new(Law::Slider, [0.4 * sizes.x]),
        Element::new(Law::PowerOfPlace, [2.0]),
        Element::new(Law::PowerOfSpeed, [2.0]),
    ];
    let elements = found.unwrap_or(&everyday);
    let declared = (0..DECLARED).map(|i| column(tracks, 1, |t| declared_columns(t)[i].clone()));
    let mut columns: Vec<Vec<f64>> = declared.collect();
    columns.extend(
        elements
            .iter()
            .map(|e| column(tracks, 1, |t| e.force(t, &sizes))),
    );
    let force: Vec<f64> = tracks.iter().flat_map(|t| t.force.clone()).collect();
    let terms: Vec<Term> = (0..columns.len()).map(|i| (i, Bound::FREE)).collect();
    let costs = Blocks::new(&columns, &force).cross_validated(&terms)?;
    Some(costs.iter().sum())
}
