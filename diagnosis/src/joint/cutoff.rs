//! Where displacement ends and noise begins, as the force says: velocities and accelerations above it only disturb.

use super::blocks::{Blocks, Term};
use super::set::{DECLARED, column, declared_columns};
use super::track::{MotionScales, Track, UnfilteredSpan};
use super::{element::Element, element::Law};
use crate::base::Base;
use crate::criteria::{BAND_ROOM, CUTOFF_HOLDS, CUTOFF_ROOM, CUTOFFS};
use crate::linear::Bound;
use rayon::prelude::*;

/// What is believed of the declared damping and mass while a cut-off is chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Derivatives {
    /// They may be anything.
    Free,
    /// At least what is declared: without it a mass that multiplies noise is fitted as none, and no cut-off is too high.
    AsDeclared,
}

/// What a cut-off leaves, cross-validated.
struct Judged {
    hz: f64,
    /// With everything free.
    free: f64,
    /// With the declared parameters within their tolerances.
    held: f64,
}

/// The lowest cut-off of a ladder whose cross-validated squares are within a few percent of the best; never inside the
/// band of any span, and none at which the declared model itself drowns in the noise of its derivatives: free parameters
/// hide that, since a mass that multiplies noise is fitted as none.
pub fn choose(
    base: &Base,
    train: &[UnfilteredSpan],
    test: &[UnfilteredSpan],
    found: Option<&[Element]>,
    derivatives: Derivatives,
) -> Option<f64> {
    let band = |s: &[UnfilteredSpan]| s.iter().map(UnfilteredSpan::band_hz).fold(0.0, f64::max);
    let (own, other) = (band(train), band(test));
    let half_rate = 0.5 / train[0].interval_s();
    let lowest = (BAND_ROOM * own.max(other)).min(half_rate);
    let step = (half_rate / lowest).powf(1.0 / (CUTOFFS - 1) as f64);
    let ladder: Vec<f64> = (0..CUTOFFS).map(|i| lowest * step.powi(i as i32)).collect();
    let judged: Vec<Judged> = ladder
        .par_iter()
        .filter_map(|&hz| {
            let hz_used = if hz > 0.99 * half_rate {
                f64::INFINITY
            } else {
                hz
            };
            let tracks: Vec<Track> = train.iter().map(|s| s.track(hz_used)).collect();
            let [free, held] = squares(base, &tracks, found, derivatives)?;
            Some(Judged { hz, free, held })
        })
        .collect();
    let least = |of: fn(&Judged) -> f64| judged.iter().map(of).fold(f64::INFINITY, f64::min);
    let most_held = CUTOFF_HOLDS * least(|j| j.held);
    let clear = || judged.iter().filter(|j| j.held <= most_held);
    let best = clear().map(|j| j.free).fold(f64::INFINITY, f64::min);
    clear().find(|j| j.free <= CUTOFF_ROOM * best).map(|j| j.hz)
}

/// Cross-validated squares of a model of everyday columns, or of elements that were found: with all parameters free, and
/// with the declared ones within their tolerances.
fn squares(
    base: &Base,
    tracks: &[Track],
    found: Option<&[Element]>,
    derivatives: Derivatives,
) -> Option<[f64; 2]> {
    let sizes = MotionScales::of(tracks);
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
    let blocks = Blocks::new(&columns, &force);
    let mut free: Vec<Term> = (0..columns.len()).map(|i| (i, Bound::FREE)).collect();
    let mut held = free.clone();
    if derivatives == Derivatives::AsDeclared {
        for i in [1, 2] {
            free[i].1.low = base.within_tolerances(i).low;
        }
    }
    for (i, term) in held.iter_mut().take(DECLARED).enumerate() {
        term.1 = base.within_tolerances(i);
    }
    let sum = |terms: &[Term]| Some(blocks.cross_validated(terms)?.iter().sum::<f64>());
    Some([sum(&free)?, sum(&held)?])
}
