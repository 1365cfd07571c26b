//! The discrete Fourier transform of any length. `rustfft` is generic over the number: who plans a transform compiles all of it
//! again, which was a third of the diagnosis, twice with its tests. Here it is compiled once.

pub use rustfft::Fft;
pub use rustfft::num_complex::Complex;

use rustfft::FftPlanner;
use std::sync::Arc;

/// The transform of `n` points, in place and without a factor.
pub fn forward(n: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_forward(n)
}

/// Its inverse, without a factor: both one after the other multiply by `n`.
pub fn inverse(n: usize) -> Arc<dyn Fft<f64>> {
    FftPlanner::new().plan_fft_inverse(n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Lengths of every kind: powers of two, composite, prime.
    #[test]
    fn a_tone_is_one_bin_and_comes_back() {
        for n in [1, 2, 8, 30, 31, 97, 1000, 1024] {
            let tone = |i: usize| Complex::from_polar(1.0, TAU * (i % n) as f64 / n as f64);
            let mut bins: Vec<_> = (0..n).map(tone).collect();
            forward(n).process(&mut bins);
            for (k, bin) in bins.iter().enumerate() {
                let expected = if k == 1 % n { n as f64 } else { 0.0 };
                assert!((bin - expected).norm() < 1e-9 * n as f64, "{n}: {k}: {bin}");
            }
            inverse(n).process(&mut bins);
            for (i, x) in bins.iter().enumerate() {
                assert!(
                    (x / n as f64 - tone(i)).norm() < 1e-12 * n as f64,
                    "{n}: {i}"
                );
            }
        }
    }
}
