//! How sure the figures are: block sandwich intervals of parameters, block bootstrap of an improvement.

use crate::model::answer::ParameterEstimate;
use crate::numbers::linear::scatter;
use nalgebra::{DMatrix, DVector};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Half a two-sided 90 % interval of the normal distribution.
pub const NINETY: f64 = 1.645;
/// Length of a block of the bootstrap, s: longer than what is left of a correlation.
const BLOCK_S: f64 = 0.25;
/// Lengths of the sandwich's blocks, s.
const BLOCKS_S: [f64; 3] = [0.25, 0.5, 1.0];

/// Values with their intervals, from how they change with the unknowns, how those vary together and how far they may have
/// been shifted; without that they are not known at all.
pub fn around(
    values: Vec<(&'static str, &'static str, f64)>,
    gradient: &DMatrix<f64>,
    unknowns: Option<&(DMatrix<f64>, DVector<f64>)>,
) -> Vec<ParameterEstimate> {
    let spread = unknowns.map(|(c, shift)| (gradient * c * gradient.transpose(), gradient * shift));
    let about = |i: usize, value: f64| {
        let Some((spread, shift)) = &spread else {
            return [f64::NEG_INFINITY, f64::INFINITY];
        };
        let half = NINETY * spread[(i, i)].max(0.0).sqrt();
        if !(spread[(i, i)].is_finite() && shift[i].is_finite()) {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        // A value that was shifted upwards is lower in truth.
        [
            value - half - shift[i].max(0.0),
            value + half + (-shift[i]).max(0.0),
        ]
    };
    let with = |(i, (name, unit, value))| (name, unit, value, about(i, value));
    values.into_iter().enumerate().map(with).collect()
}

/// Standard deviations of the unknowns of a linear fit from what it leaves, by [`scatter`] of half a second and more.
pub fn by_blocks(columns: &[Vec<f64>], left: &[f64], interval_s: f64) -> Vec<f64> {
    let block = ((BLOCKS_S[1] / interval_s) as usize).max(4);
    scatter(columns, left, (left.len() / block).max(4))
}

/// 90 % interval of `rms(before) - rms(after)`, by resampling blocks.
pub fn improvement(before: &[Vec<f64>], after: &[Vec<f64>], interval_s: f64) -> [f64; 2] {
    let block = ((BLOCK_S / interval_s) as usize).max(4);
    let squares = |parts: &[Vec<f64>]| -> Vec<(f64, f64)> {
        parts
            .iter()
            .flat_map(|p| p.chunks(block))
            .map(|c| (c.iter().map(|x| x * x).sum(), c.len() as f64))
            .collect()
    };
    let (b, a) = (squares(before), squares(after));
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let mut falls: Vec<f64> = (0..1000)
        .map(|_| {
            let (mut before, mut after, mut n) = (0.0, 0.0, 0.0);
            for _ in 0..b.len() {
                let i = (rng.next_u64() % b.len() as u64) as usize;
                before += b[i].0;
                after += a[i].0;
                n += b[i].1;
            }
            (before / n).sqrt() - (after / n).sqrt()
        })
        .collect();
    falls.sort_by(f64::total_cmp);
    [falls[50], falls[949]]
}
