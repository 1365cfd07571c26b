//! The second derivative of a reading at its first sample.

use crate::numbers::linear::{dot, gram};
use crate::record::converter_step;
use nalgebra::DVector;

/// Samples of the shortest segment: fewer determine a reading's noise too poorly.
pub const SHORTEST: usize = 16;
/// Degree of the polynomial through a segment.
const DEGREE: i32 = 3;
/// Longest segment, as a fraction of the record.
const LONGEST: f64 = 0.25;
/// Standard deviations to either side of an estimate within which longer segments must agree.
const AGREE: f64 = 3.0;

/// A least-squares polynomial through a segment.
struct LocalPolynomial {
    /// Second derivative at its first sample.
    curvature: f64,
    /// Its standard deviation for unit noise in each sample.
    per_noise: f64,
    /// Rms residual, corrected for the number of coefficients.
    leaves: f64,
}

impl LocalPolynomial {
    fn new(y: &[f64], interval_s: f64) -> Option<Self> {
        let n = y.len();
        let t = |i: usize| i as f64 / n as f64;
        let columns: Vec<Vec<f64>> = (0..=DEGREE)
            .map(|power| (0..n).map(|i| t(i).powi(power)).collect())
            .collect();
        let right = DVector::from_fn(columns.len(), |i, _| dot(&columns[i], y));
        let inverse = gram(&columns).try_inverse()?;
        let w = &inverse * right;
        let left: f64 = (0..n)
            .map(|i| {
                let fit: f64 = (0..columns.len()).map(|c| w[c] * columns[c][i]).sum();
                (y[i] - fit).powi(2)
            })
            .sum();
        let span_s = n as f64 * interval_s;
        let twice = 2.0 / (span_s * span_s);
        Some(Self {
            curvature: twice * w[2],
            per_noise: twice * inverse[(2, 2)].max(0.0).sqrt(),
            leaves: (left / (n - columns.len()) as f64).sqrt(),
        })
    }
}

/// Second derivative of a reading at its first sample. Segments from there get longer as long as each agrees with all
/// shorter ones within their scatter (the rule of intersecting confidence intervals: Goldenshluger and Nemirovski, On
/// spatially adaptive estimation of nonparametric regression, 1997): noise scatters a short one, a long one has more
/// bends than a polynomial. Only what exceeds the noise is returned.
pub fn at_the_start(x: &[f64], interval_s: f64) -> f64 {
    let longest = (LONGEST * x.len() as f64) as usize;
    // A slow motion on a coarse converter repeats the same value: that does not mean no noise.
    let mut noise = f64::INFINITY;
    let steps = converter_step::step(x).map_or(0.0, |step| step / 12_f64.sqrt());
    let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut best = 0.0;
    let mut samples = SHORTEST;
    while samples <= longest {
        let Some(segment) = LocalPolynomial::new(&x[..samples], interval_s) else {
            break;
        };
        noise = noise.min(segment.leaves).max(steps);
        let scatter = noise * segment.per_noise;
        low = low.max(segment.curvature - AGREE * scatter);
        high = high.min(segment.curvature + AGREE * scatter);
        if low > high {
            break;
        }
        let doubt = (scatter / segment.curvature.abs().max(f64::MIN_POSITIVE)).min(1.0);
        best = segment.curvature * (1.0 - doubt * doubt);
        samples += samples / 2;
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    fn noise(rms: f64) -> impl FnMut() -> f64 {
        let mut rng =
            <rand_xoshiro::Xoshiro256PlusPlus as rand_core::SeedableRng>::seed_from_u64(11);
        move || rms * Distribution::<f64>::sample(&StandardNormal, &mut rng)
    }

    #[test]
    fn a_sine_has_its_acceleration_at_its_crest_in_noise_too() {
        let w = TAU * 0.7;
        for rms in [0.0, 1e-3, 1e-2] {
            let mut noise = noise(rms);
            let x: Vec<f64> = (0..5000)
                .map(|i| 10.0 * (w * f64::from(i) * 2e-3).cos() + noise())
                .collect();
            let a = at_the_start(&x, 2e-3);
            let off = a / (-10.0 * w * w) - 1.0;
            assert!(off.abs() < 0.1, "{rms}: {off}");
        }
    }

    #[test]
    fn a_ramp_has_none_and_a_slow_one_whose_reading_has_steps_has_next_to_none() {
        let ramp = |step: f64| -> Vec<f64> {
            let x = (0..4000).map(|i| 5.0 * f64::from(i) * 1e-3);
            x.map(|x| (x / step).round() * step).collect()
        };
        assert!(at_the_start(&ramp(1e-9), 1e-3).abs() < 0.1);
        // The ramp passes a step in 8 samples; as an acceleration these would be thousands of mm/s^2.
        let coarse = at_the_start(&ramp(0.04), 1e-3);
        assert!(coarse.abs() < 5.0, "{coarse}");
    }

    #[test]
    fn an_acceleration_that_soon_changes_is_that_of_the_beginning() {
        // 300 mm/s^2 for 0.15 s, then none: a ramp with rounded ends, like a robot's.
        let mut noise = noise(1e-3);
        let x: Vec<f64> = (0..6000)
            .map(|i| {
                let t = f64::from(i) * 1e-3;
                let soon = t.min(0.15);
                150.0 * soon * soon + 45.0 * (t - soon) + noise()
            })
            .collect();
        let a = at_the_start(&x, 1e-3);
        assert!((a / 300.0 - 1.0).abs() < 0.15, "{a}");
    }
}
