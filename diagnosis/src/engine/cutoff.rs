//! Cut-off between displacement and noise, judged by the force: velocities and accelerations above it only disturb.

use super::search::DECLARED;
use crate::criteria::{BLOCKS, CUTOFF_HOLDS, CUTOFFS};
use crate::laws::specimen::element::{Element, Law};
use crate::laws::specimen::track::{MotionScales, Track, UnfilteredSpan};
use crate::model::base::Base;
use crate::numbers::bounded::Equations;
use crate::numbers::linear::Bound;
use rayon::prelude::*;

/// Judged cut-offs, the lowest first.
pub struct Ladder(Vec<Judged>);

/// Number of rungs that are judged together.
const AT_ONCE: usize = 2;
/// Rungs whose squares are this multiple of the best are past it.
const PAST: f64 = 1.2;

/// Cross-validated squares at a cut-off.
struct Judged {
    hz: f64,
    /// With all parameters free.
    free: f64,
    /// With the declared parameters held within their tolerances.
    held: f64,
}

/// Cut-offs of a ladder, judged: never inside the band of any span. The force is described by everyday laws, and by the
/// columns that `more` gives for a motion.
pub fn ladder(
    base: &Base,
    train: &[UnfilteredSpan],
    more: impl Fn(&Track) -> Vec<Vec<f64>> + Sync,
) -> Ladder {
    let half_rate = 0.5 / train[0].interval_s();
    let each = train.iter().map(|s| s.past_band_hz(0.0));
    let lowest = each.fold(0.0, f64::max);
    let step = (half_rate / lowest).powf(1.0 / (CUTOFFS - 1) as f64);
    let ladder: Vec<f64> = (0..CUTOFFS).map(|i| lowest * step.powi(i as i32)).collect();
    let judge = |&hz: &f64| {
        let hz_used = if hz > 0.99 * half_rate {
            f64::INFINITY
        } else {
            hz
        };
        let tracks: Vec<Track> = train.iter().map(|s| s.track(hz_used)).collect();
        let [free, held] = squares(base, &tracks, &more)?;
        Some(Judged { hz, free, held })
    };
    let mut judged: Vec<Judged> = Vec::new();
    let mut best = f64::INFINITY;
    for rungs in ladder.chunks(AT_ONCE) {
        let own: Vec<Judged> = rungs.par_iter().filter_map(judge).collect();
        let least = own.iter().map(|j| j.free).fold(f64::INFINITY, f64::min);
        judged.extend(own);
        // Noise grows with every further rung.
        if least.is_finite() && least > PAST * best {
            break;
        }
        best = best.min(least);
    }
    Ladder(judged)
}

impl Ladder {
    /// The lowest cut-off whose cross-validated squares are within a factor of the best, but not where the declared model
    /// itself drowns in the noise of its derivatives. Free parameters hide that, since a mass that multiplies noise is
    /// fitted as zero.
    pub fn lowest(&self, room: f64) -> Option<f64> {
        let least = |of: fn(&Judged) -> f64| self.0.iter().map(of).fold(f64::INFINITY, f64::min);
        let most_held = CUTOFF_HOLDS * least(|j| j.held);
        let clear = || self.0.iter().filter(|j| j.held <= most_held);
        let best = clear().map(|j| j.free).fold(f64::INFINITY, f64::min);
        clear().find(|j| j.free <= room * best).map(|j| j.hz)
    }
}

/// Cross-validated squares of a model of common columns: with all parameters free, and with the declared ones held
/// within their tolerances. Free damping and mass are at least the declared ones: otherwise a mass that multiplies
/// noise is fitted as zero, and no cut-off is too high.
fn squares(
    base: &Base,
    tracks: &[Track],
    more: impl Fn(&Track) -> Vec<Vec<f64>>,
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
    let column = |of: &dyn Fn(&Track) -> Vec<f64>| -> Vec<f64> {
        let each = tracks.iter().flat_map(|t| t.column_of(&of(t), 1));
        each.collect()
    };
    let declared = (0..DECLARED).map(|i| column(&|t| t.declared_columns()[i].clone()));
    let mut columns: Vec<Vec<f64>> = declared.collect();
    columns.extend(everyday.iter().map(|e| column(&|t| e.force(t, &sizes))));
    let others: Vec<Vec<Vec<f64>>> = tracks.iter().map(more).collect();
    for i in 0..others.first().map_or(0, Vec::len) {
        let own = tracks.iter().zip(&others);
        let each = own.flat_map(|(t, own)| t.column_of(&own[i], 1));
        columns.push(each.collect());
    }
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
    let mut whole = Equations::zero(bounds.len());
    parts.iter().for_each(|part| whole.add(part, 1.0));
    let left = parts.iter().map(|part| {
        let mut others = whole.clone();
        others.add(part, -1.0);
        Some(part.left(&others.solve(bounds)?))
    });
    left.sum()
}
