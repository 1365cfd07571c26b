//! Level of a band at its quiet times. Noise is always present; what a model lacks comes with the motion: at reversals,
//! at contacts, at the largest speeds. So the lower quartile of a band's power over time gives the noise, the mean
//! gives both. It is an upper bound: if something acts all the time, its quietest quarter counts as noise.

use fourier::Complex;
use std::f64::consts::PI;

/// Fraction of the time that is used: during the rest of it anything may happen.
const QUIET: f64 = 0.25;
/// The power of normal noise in a band is exponentially distributed: its quantile there, over its mean.
const QUANTILE: f64 = 0.287_682;
/// That quantile of the square of a normal variable.
const NORMAL: f64 = 0.101_531;
/// Mean square of the window over the band, a squared half sine without corners at its ends: its response dies out
/// within twice the reciprocal of the band's width.
const WINDOW: f64 = 0.375;
/// Time for a window's response to die out, times the band's width.
const FORGOTTEN: f64 = 2.0;
/// Fewest windows that determine a quantile.
const LEAST_WINDOWS: f64 = 12.0;

/// Power density between two frequencies at quiet times, unit^2 / Hz; `None` if the signal is too short for the band.
pub fn density(x: &[f64], interval_s: f64, low_hz: f64, high_hz: f64) -> Option<f64> {
    let n = x.len();
    let width = high_hz - low_hz;
    let seconds = n as f64 * interval_s;
    if seconds * width < FORGOTTEN * LEAST_WINDOWS || high_hz * interval_s > 0.5 {
        return None;
    }
    // Join the ends: a step there would be one more loud time; what remains is small.
    let slope = (x[n - 1] - x[0]) / (n - 1) as f64;
    let mut bins: Vec<Complex<f64>> = x
        .iter()
        .enumerate()
        .map(|(i, x)| Complex::new(x - slope * i as f64, 0.0))
        .collect();
    fourier::forward(n).process(&mut bins);
    for (k, bin) in bins.iter_mut().enumerate() {
        let part = (k as f64 / seconds - low_hz) / width;
        let inside = 2 * k < n && (0.0..1.0).contains(&part);
        *bin *= if inside {
            2.0 * (PI * part).sin().powi(2) / n as f64
        } else {
            0.0
        };
    }
    fourier::inverse(n).process(&mut bins);
    let mut power: Vec<f64> = bins.iter().map(Complex::norm_sqr).collect();
    let at = (QUIET * n as f64) as usize;
    let (_, quiet, _) = power.select_nth_unstable_by(at, f64::total_cmp);
    // The squared envelope is twice the squared signal.
    Some(*quiet / QUANTILE / (2.0 * WINDOW * width))
}

/// Variance of white noise from fourth differences at quiet times: five samples are unaffected by a reversal three
/// samples away. For motions that leave hardly any band free.
pub fn of_differences(x: &[f64]) -> f64 {
    let fourth = |w: &[f64]| w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4];
    let mut squares: Vec<f64> = x.windows(5).map(|w| fourth(w).powi(2)).collect();
    let at = (QUIET * squares.len() as f64) as usize;
    if at >= squares.len() {
        return f64::INFINITY;
    }
    let (_, quiet, _) = squares.select_nth_unstable_by(at, f64::total_cmp);
    *quiet / NORMAL / 70.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use std::f64::consts::TAU;

    fn white(n: usize, seed: u64) -> Vec<f64> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut random)).collect()
    }

    #[test]
    fn of_white_noise_it_is_the_density() {
        let h = 2e-3;
        for seed in 0..20 {
            let found = density(&white(6000, seed), h, 50.0, 100.0).unwrap();
            // A variance of 1 over 250 Hz.
            let ratio = found * 250.0;
            assert!((0.75..1.3).contains(&ratio), "{seed}: {ratio}");
        }
    }

    #[test]
    fn jumps_at_reversals_are_not_heard() {
        let h = 2e-3;
        for seed in 0..20 {
            // Friction of 300 times the noise, at 1 Hz.
            let jumps = |i: usize| 300.0 * (TAU * i as f64 * h).cos().signum();
            let noise = white(6000, seed);
            let x: Vec<f64> = noise
                .iter()
                .enumerate()
                .map(|(i, n)| n + jumps(i))
                .collect();
            let ratio = density(&x, h, 60.0, 180.0).unwrap() * 250.0;
            assert!((0.75..1.8).contains(&ratio), "{seed}: {ratio}");
        }
    }

    #[test]
    fn differences_know_the_noise_between_reversals_a_dozen_samples_apart() {
        for seed in 0..20 {
            let jumps = |i: usize| {
                if (i / 12).is_multiple_of(2) {
                    300.0
                } else {
                    -300.0
                }
            };
            let noise = white(3000, seed);
            let x: Vec<f64> = noise
                .iter()
                .enumerate()
                .map(|(i, n)| n + jumps(i))
                .collect();
            let ratio = of_differences(&x).sqrt();
            // A third of the differences contain a jump: the quietest quarter of all is three eighths of the others.
            assert!((1.2..1.8).contains(&ratio), "{seed}: {ratio}");
        }
    }

    #[test]
    fn a_band_that_is_too_narrow_for_the_record_tells_nothing() {
        assert!(density(&white(1000, 1), 1e-2, 10.0, 11.0).is_none());
        assert!(density(&white(1000, 1), 1e-2, 40.0, 60.0).is_none());
    }
}
