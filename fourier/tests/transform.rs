//! A transform and its inverse. Beside the library, which takes seconds to compile a second time.
#![allow(missing_docs)]

use fourier::{Complex, forward, inverse};
use std::f64::consts::TAU;

/// The bits of a transform depend on its length alone, not on what this thread has transformed before.
#[test]
fn other_lengths_before_it_change_no_bit() {
    let signal = |n: usize| (0..n).map(|i| Complex::new((0.37 * i as f64).sin(), 0.0));
    let after = |others: &[usize]| -> Vec<Complex<f64>> {
        let others = others.to_vec();
        let fresh = std::thread::spawn(move || {
            for n in others {
                forward(n).process(&mut signal(n).collect::<Vec<_>>());
            }
            let mut bins: Vec<_> = signal(288).collect();
            forward(288).process(&mut bins);
            bins
        });
        fresh.join().unwrap()
    };
    assert_eq!(after(&[]), after(&[2304]));
    // More lengths than are kept.
    assert_eq!(after(&[]), after(&(280..330).collect::<Vec<_>>()));
}

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
