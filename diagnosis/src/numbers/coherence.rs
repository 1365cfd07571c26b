//! The part of an output that a linear model of any order can derive from an input: the coherence of the two (Bendat
//! and Piersol, Random Data, chapter 6).

use fourier::Complex;

/// Number of Hann windows, overlapping by half.
const WINDOWS: usize = 16;
/// Effective fraction of independent windows, when overlapping by half.
const APART: f64 = 0.95;

/// The fraction of the output's squares; `None` if the record is too short. A response that rings longer than a window,
/// a seventeenth of twice the record, counts as if it came from elsewhere.
pub fn linear_share(input: &[f64], output: &[f64]) -> Option<f64> {
    let spectra = fourier::cross_spectra(input, output, WINDOWS)?;
    // The mean squared coherence of unrelated signals.
    let by_chance = 1.0 / (APART * spectra.windows as f64);
    let of = |(uu, yy, uy): &(f64, f64, Complex<f64>)| {
        let seen = uy.norm_sqr() / (uu * yy).max(f64::MIN_POSITIVE);
        yy * (seen - by_chance) / (1.0 - by_chance)
    };
    let whole: f64 = spectra.lines.iter().map(|s| s.1).sum();
    let linear: f64 = spectra.lines.iter().map(of).sum();
    Some((linear / whole.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn what_a_filter_makes_is_linear_and_what_comes_from_elsewhere_is_not() {
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(5);
        let mut white = || -> Vec<f64> {
            (0..16_000)
                .map(|_| StandardNormal.sample(&mut random))
                .collect()
        };
        let (u, other) = (white(), white());
        let mut y = u.clone();
        for i in 1..y.len() {
            y[i] += 0.8 * y[i - 1];
        }
        let share = |y: &[f64]| linear_share(&u, y).unwrap();
        assert!(share(&y) > 0.95, "{}", share(&y));
        assert!(share(&other) < 0.03, "{}", share(&other));
        // White noise of the filtered signal's power: 1 / (1 - 0.8^2) = 1 / 0.36.
        let mixed: Vec<f64> = y.iter().zip(&other).map(|(y, o)| y + o / 0.6).collect();
        // The filter's power lies where it exceeds the noise: the fraction is near a half, but not equal.
        assert!((share(&mixed) - 0.5).abs() < 0.05, "{}", share(&mixed));
        assert_eq!(linear_share(&u[..200], &y[..200]), None);
    }
}
