//! Noise of a record without a rest: the difference between samples at the same place and speed at other times. The
//! motion's effects are equal then, unless steep; noise of any colour is not (the nearest-neighbour or Gamma test of
//! Stefansson, Koncar and Jones, Neural Computing and Applications 5, 1997, 131). An upper bound: memory differs, too.

use crate::numbers::linear::{dot, gram};
use crate::numbers::signals::{add_columns, deviation, mean};
use crate::record::recording::range;
use crate::record::spectrum::{motion_band_hz, smooth};
use nalgebra::DVector;

/// Largest number of samples compared: all pairs are examined.
const COMPARED: usize = 2000;
/// Smallest distance in time between neighbours, as a fraction of the band's period.
const APART: f64 = 0.25;
/// Fraction of the differences that is kept, and its mean square for a normal distribution: the largest are omitted,
/// since a force that jumps at a reversal differs there without noise.
const KEPT: (f64, f64) = (0.9, 0.623);

/// Upper bound of the noise rms in a residual; `None` if the motion has no band.
pub fn rms(residual: &[f64], input: &[f64], interval_s: f64) -> Option<f64> {
    let band_hz = motion_band_hz(input, interval_s)?;
    if range(input) <= 0.0 {
        return None;
    }
    let motion = smooth(input, interval_s, (6.0 * band_hz).min(0.3 / interval_s));
    let every = residual.len().div_ceil(COMPARED);
    let thin = |x: &[f64]| -> Vec<f64> { x.iter().step_by(every).copied().collect() };
    let (x, v, a) = (thin(&motion.x), thin(&motion.v), thin(&motion.a));
    let rest = without_linear(thin(residual), [&x, &v, &a])?;
    let unit = |x: &[f64]| -> Vec<f64> {
        let by = 1.0 / range(x).max(f64::MIN_POSITIVE);
        x.iter().map(|x| x * by).collect()
    };
    let (x, v) = (unit(&x), unit(&v));
    let gap = (APART / band_hz / (interval_s * every as f64)).ceil() as usize;
    let nearest = |i: usize| {
        (0..x.len())
            .filter(|j| i.abs_diff(*j) > gap)
            .min_by(|&j, &k| {
                let far = |j: usize| (x[i] - x[j]).powi(2) + (v[i] - v[j]).powi(2);
                far(j).total_cmp(&far(k))
            })
    };
    let mut squares: Vec<f64> = (0..x.len())
        .filter_map(|i| Some((rest[i] - rest[nearest(i)?]).powi(2)))
        .collect();
    if squares.len() < 20 {
        return None;
    }
    squares.sort_by(f64::total_cmp);
    squares.truncate((KEPT.0 * squares.len() as f64) as usize);
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    Some((0.5 * mean / KEPT.1).sqrt())
}

/// Without the response of a spring, a damper, a mass and an offset: neighbours are near, not the same.
fn without_linear(mut rest: Vec<f64>, motion: [&Vec<f64>; 3]) -> Option<Vec<f64>> {
    let n = rest.len() as f64;
    let centred = |x: &[f64]| -> Vec<f64> {
        let mean = mean(x);
        let by = 1.0 / deviation(x).max(f64::MIN_POSITIVE);
        x.iter().map(|x| (x - mean) * by).collect()
    };
    let mut columns: Vec<Vec<f64>> = motion.iter().map(|x| centred(x)).collect();
    columns.push(vec![1.0; rest.len()]);
    let mut matrix = gram(&columns);
    for i in 0..columns.len() {
        matrix[(i, i)] += 1e-9 * n;
    }
    let right = DVector::from_fn(columns.len(), |i, _| dot(&columns[i], &rest));
    let share = matrix.cholesky()?.solve(&right);
    add_columns(&mut rest, &columns, share.as_slice(), -1.0);
    Some(rest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use std::f64::consts::TAU;

    #[test]
    fn coloured_noise_is_known_beside_a_force_of_place_and_speed() {
        for seed in 0..6 {
            let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
            let mut low = 0.0;
            let h = 5e-3;
            let x: Vec<f64> = (0..6000)
                .map(|i| {
                    let t = i as f64 * h;
                    (TAU * 0.31 * t).sin() + 0.7 * (TAU * 0.83 * t).sin()
                })
                .collect();
            let noise: Vec<f64> = (0..6000)
                .map(|_| {
                    let e: f64 = StandardNormal.sample(&mut random);
                    low = 0.8 * low + 0.6 * e;
                    low
                })
                .collect();
            let rest: Vec<f64> = x
                .iter()
                .zip(&noise)
                .map(|(x, n)| n + 3.0 * (2.0 * x).sin())
                .collect();
            let found = rms(&rest, &x, h).unwrap();
            assert!((found - 1.0).abs() < 0.3, "{found}");
        }
    }
}
