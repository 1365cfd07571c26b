//! The discrete Fourier transform of any length. `rustfft` is generic over the number: who plans a transform compiles all of it
//! again, which was a third of the diagnosis, twice with its tests. Here it is compiled once.

pub use rustfft::Fft;
pub use rustfft::num_complex::Complex;

use rustfft::{FftDirection, FftPlanner};
use std::cell::RefCell;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Largest number of plans that a thread keeps.
const KEPT: usize = 32;

type Plan = (usize, FftDirection, Arc<dyn Fft<f64>>);

thread_local! {
    /// The latest plans of this thread, the newest last.
    static PLANS: RefCell<Vec<Plan>> = const { RefCell::new(Vec::new()) };
}

/// A plan kept from an earlier call, or a new one. Each is made by a planner of its own: a planner builds a plan from the parts
/// of earlier ones, so that the last bits of a transform would depend on the lengths that this thread has met before.
fn planned(n: usize, direction: FftDirection) -> Arc<dyn Fft<f64>> {
    PLANS.with_borrow_mut(|plans| {
        let known = plans.iter().position(|p| p.0 == n && p.1 == direction);
        let plan = match known {
            Some(at) => plans.remove(at),
            None => (n, direction, FftPlanner::new().plan_fft(n, direction)),
        };
        if plans.len() == KEPT {
            plans.remove(0);
        }
        let fft = plan.2.clone();
        plans.push(plan);
        fft
    })
}

/// The transform of `n` points, in place and without a factor.
pub fn forward(n: usize) -> Arc<dyn Fft<f64>> {
    planned(n, FftDirection::Forward)
}

/// Its inverse, without a factor: both one after the other multiply by `n`.
pub fn inverse(n: usize) -> Arc<dyn Fft<f64>> {
    planned(n, FftDirection::Inverse)
}

/// The shortest length of at least `n` that has no prime factor beyond 5: its transform takes a fraction of a prime's.
pub fn quick_length(n: usize) -> usize {
    let quick = |mut m: usize| {
        for prime in [2, 3, 5] {
            while m.is_multiple_of(prime) {
                m /= prime;
            }
        }
        m == 1
    };
    (n.max(1)..).find(|m| quick(*m)).unwrap_or(n)
}

/// Sums of an input's and an output's powers over windows that overlap by half, line by line from 0 Hz to below half the sampling
/// rate (Welch, IEEE Trans. Audio Electroacoust. 15, 1967).
pub struct CrossSpectra {
    /// Samples of a window: line `k` is at `k / length` of the sampling rate.
    pub length: usize,
    /// How many windows were summed.
    pub windows: usize,
    /// The input's power, the output's, and the cross spectrum, which is conjugated in the input.
    pub lines: Vec<(f64, f64, Complex<f64>)>,
}

/// Over so many Hann windows of as many samples as the signals have, each without its mean; `None` where a window has less than
/// 32 samples.
pub fn cross_spectra(input: &[f64], output: &[f64], windows: usize) -> Option<CrossSpectra> {
    let samples = input.len().min(output.len());
    let length = 2 * samples / (windows + 1);
    if length < 32 {
        return None;
    }
    let hann = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / length as f64).cos();
    let plan = forward(length);
    let transform = |x: &[f64]| {
        let mean = x.iter().sum::<f64>() / length as f64;
        let windowed = |(i, x): (usize, &f64)| Complex::new((x - mean) * hann(i), 0.0);
        let mut bins: Vec<Complex<f64>> = x.iter().enumerate().map(windowed).collect();
        plan.process(&mut bins);
        bins
    };
    let half = length / 2;
    let mut found = CrossSpectra {
        length,
        windows: 0,
        lines: vec![(0.0, 0.0, Complex::default()); half],
    };
    for start in (0..=samples - length).step_by(half) {
        let [u, y] = [input, output].map(|x| transform(&x[start..start + length]));
        for ((uu, yy, uy), (u, y)) in found.lines.iter_mut().zip(u.iter().zip(&y)) {
            *uu += u.norm_sqr();
            *yy += y.norm_sqr();
            *uy += u.conj() * y;
        }
        found.windows += 1;
    }
    Some(found)
}
