//! A transform and its inverse. Beside the library, which takes seconds to compile a second time.
#![allow(missing_docs)]

use fourier::{Complex, forward, inverse};
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
