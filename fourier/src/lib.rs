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
