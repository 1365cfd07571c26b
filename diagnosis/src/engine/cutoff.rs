//! Cut-off between displacement and noise, judged by the force: velocities and accelerations above it only disturb.

use super::bounded::Equations;
use super::search::DECLARED;
use crate::criteria::{BLOCKS, CUTOFF_HOLDS, CUTOFF_ROOM, CUTOFFS};
use crate::laws::specimen::element::{Element, Law};
use crate::laws::specimen::track::{MotionScales, Track, UnfilteredSpan};
use crate::model::base::Base;
use crate::numbers::linear::Bound;
use rayon::prelude::*;

/// Cross-validated squares at a cut-off.
struct Judged {
    hz: f64,
    /// With all parameters free.
    free: f64,
    /// With the declared parameters held within their tolerances.
    held: f64,
}

/// The lowest cut-off of a ladder whose cross-validated squares are within a few percent of the best; never inside the
/// band of any span, nor where the declared model itself drowns in the noise of its derivatives. Free parameters hide
/// that, since a mass that multiplies noise is fitted as zero.
pub fn choose(base: &Base, train: &[UnfilteredSpan]) -> Option<f64> {
    let half_rate = 0.5 / train[0].interval_s();
    let each = train.iter().map(|s| s.past_band_hz(0.0));
    let lowest = each.fold(0.0, f64::max);
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
            let [free, held] = squares(base, &tracks)?;
            Some(Judged { hz, free, held })
        })
        .collect();
    let least = |of: fn(&Judged) -> f64| judged.iter().map(of).fold(f64::INFINITY, f64::min);
    let most_held = CUTOFF_HOLDS * least(|j| j.held);
    let clear = || judged.iter().filter(|j| j.held <= most_held);
    let best = clear().map(|j| j.free).fold(f64::INFINITY, f64::min);
    clear().find(|j| j.free <= CUTOFF_ROOM * best).map(|j| j.hz)
}

/// Cross-validated squares of a model of common columns: with all parameters free, and with the declared ones held
/// within their tolerances. Free damping and mass are at least the declared ones: otherwise a mass that multiplies
/// noise is fitted as zero, and no cut-off is too high.
fn squares(base: &Base, tracks: &[Track]) -> Option<[f64; 2]> {
    let sizes = MotionScales::of(tracks);
    let everyday = [
        Element::new(Law::Saturating, [0.05 * sizes.v]),
        Element::new(Law::Slider, [0.01 * sizes.x]),
        Element::new(Law::Slider, [0.1 * sizes.x]),
        Element::new(Law::Slider, [0.4 * sizes.x]),
        Element::new(Law::PowerOfPlace, [2.0]),
        Element::new(Law::PowerOfSpeed, [2.0]),
    ];
    let column = |of: &dyn Fn(&Track) -> Vec<f64>| -> Vec<f64> {
        let each = tracks.iter().flat_map(|t| t.column_of(&of(t), 1));
        each.collect()
    };
    let declared = (0..DECLARED).map(|i| column(&|t| t.declared_columns()[i].clone()));
    let mut columns: Vec<Vec<f64>> = declared.collect();
    columns.extend(everyday.iter().map(|e| column(&|t| e.force(t, &sizes))));
    let force: Vec<f64> = tracks.iter().flat_map(|t| t.force.clone()).collect();
    let block = |b: usize| b * force.len() / BLOCKS..(b + 1) * force.len() / BLOCKS;
    let parts = (0..BLOCKS).map(|b| Equations::of(&columns, &force, block(b)));
    let parts: Vec<Equations> = parts.collect();
    let mut free = vec![Bound::FREE; columns.len()];
    let mut held = free.clone();
    for i in [1, 2] {
        free[i].low = base.within_tolerances(i).low;
    }
    for (i, bound) in held.iter_mut().take(DECLARED).enumerate() {
        *bound = base.within_tolerances(i);
    }
    Some([left_out(&parts, &free)?, left_out(&parts, &held)?])
}

/// Sum of the residual squares of each block, fitted to the others.
fn left_out(parts: &[Equations], bounds: &[Bound]) -> Option<f64> {
    let (low, high): (Vec<f64>, Vec<f64>) = bounds.iter().map(|b| (b.low, b.high)).unzip();
    let mut whole = Equations::zero(bounds.len());
    parts.iter().for_each(|part| whole.add(part, 1.0));
    let left = parts.iter().map(|part| {
        let mut others = whole.clone();
        others.add(part, -1.0);
        Some(part.left(&others.solve(&low, &high)?))
    });
    left.sum()
}
