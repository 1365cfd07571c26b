//! Coloured noise, and converters.

use crate::draws::Draws;
use crate::fine::rms;
use std::f64::consts::TAU;

/// Stationary noise of rms `sigma`: white, low-passed and resonant parts in random proportion.
pub(crate) fn coloured(n: usize, sigma: f64, rate_hz: f64, rng: &mut Draws) -> Vec<f64> {
    let keep = (-TAU * rng.log_between(8.0, 120.0) / rate_hz).exp();
    let (low_share, ring_share) = (rng.between(0.0, 0.9), rng.between(0.0, 0.5));
    let radius = rng.between(0.7, 0.97);
    let turn = 2.0 * radius * (TAU * rng.between(30.0, 0.4 * rate_hz) / rate_hz).cos();
    let (mut low, mut ring) = (0.0, [0.0; 2]);
    let low_scale = low_share * (1.0 - keep * keep).sqrt();
    let ring_scale = ring_share * (1.0 - radius * radius);
    let settle = 2000;
    let mut noise: Vec<f64> = (0..n + settle)
        .map(|_| {
            low = keep * low + rng.normal();
            let next = turn * ring[0] - radius * radius * ring[1] + rng.normal();
            ring = [next, ring[0]];
            rng.normal() + low_scale * low + ring_scale * next
        })
        .skip(settle)
        .collect();
    let scale = sigma / rms(&noise);
    noise.iter_mut().for_each(|x| *x *= scale);
    noise
}

/// The nearest code of a converter of `bits` over `-full_scale..full_scale`.
pub(crate) fn convert(x: f64, full_scale: f64, bits: u32) -> f64 {
    let step = 2.0 * full_scale / f64::from(1u32 << bits);
    (x / step).round() * step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn has_its_rms_and_is_correlated() {
        let x = coloured(40_000, 0.3, 1000.0, &mut Draws::new(3));
        assert!((rms(&x) - 0.3).abs() < 1e-12);
        let lag1: f64 = x.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (40_000.0 * 0.09);
        assert!(lag1.abs() > 0.02, "correlation {lag1}");
    }

    #[test]
    fn a_converter_errs_by_half_a_code_at_most() {
        for i in 0..1000 {
            let x = f64::from(i) * 0.0123 - 6.0;
            assert!((convert(x, 10.0, 12) - x).abs() <= 10.0 / 4096.0 + 1e-12);
        }
    }
}
