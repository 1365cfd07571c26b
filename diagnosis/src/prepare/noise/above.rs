//! Noise of a record without a rest: the spectrum above the band of the motion, extrapolated below it.

use super::quiet;
use crate::numbers::signals::median;
use crate::record::spectrum::{Density, motion_band_hz};
use fourier::Complex;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

/// Multiple of the motion's band above which a record is noise.
const ABOVE: f64 = 3.0;
/// Number of bands above that, whose medians are compared.
const BANDS: usize = 6;
/// Ratio of medians above which they contain more than noise: harmonics of friction, or a filter before the converter.
const DISAGREE: f64 = 8.0;
/// Width of a band over that of the motion, enough to be quiet between two reversals.
const WIDE: f64 = 6.0;
/// A band whose quiet level is below this fraction of its mean holds more than noise: each figure is known to a third.
const ALIKE: f64 = 0.7;
/// Smallest part of the spectrum that must lie above the motion; otherwise its last part gives a guess.
const ROOM: f64 = 0.2;
/// Low-passed noise is larger below the motion's band than can be seen above it: by this factor in rms, on average, if
/// the lowest band is the highest and the spectrum keeps rising below it.
const HIDDEN: f64 = 1.15;
/// Median over mean of an averaged periodogram of 30 windows.
const MEDIAN: f64 = 0.98;

/// Noise as seen in the spectrum above the motion.
#[derive(Clone, Debug)]
pub struct Above {
    /// Power density, unit^2 / Hz, from 0 to half the rate.
    density: Vec<f64>,
    /// True if the bands agree; otherwise the figure is a guess.
    pub sure: bool,
}

impl Above {
    /// From a `residual` in the channel's unit and the input motion; with `quiet_hz`, as at quiet times, from that
    /// frequency on. `None` if the record is too short for a spectrum.
    pub fn of(
        residual: &[f64],
        input: &[f64],
        interval_s: f64,
        quiet_hz: Option<f64>,
    ) -> Option<Self> {
        let motion_hz = motion_band_hz(input, interval_s);
        let seen = Density::of(residual, interval_s)?;
        let (n, bin_hz) = (seen.power.len(), seen.bin_hz);
        // The last bins lie on the slope of the converter's own filter.
        let end = n - n / 20;
        let latest = end.checked_sub(((ROOM * n as f64) as usize).max(BANDS))?;
        let first = motion_hz.map_or(f64::INFINITY, |hz| {
            (ABOVE * hz).max(quiet_hz.unwrap_or(0.0))
        });
        let has_room = first / bin_hz < latest as f64;
        let from = ((first / bin_hz).ceil().min(latest as f64) as usize).max(1);
        let width = (end - from) / BANDS;
        let mut medians: Vec<f64> = seen.power[from..end]
            .chunks_exact(width)
            .take(BANDS)
            .map(|c| median(c) / MEDIAN)
            .collect();
        if quiet_hz.is_some() {
            let edge = |band: usize| (from + band * width) as f64 * bin_hz;
            let edges: [f64; BANDS + 1] = std::array::from_fn(edge);
            quieten(
                &mut medians,
                &edges,
                residual,
                (motion_hz.unwrap_or(0.0), interval_s),
            );
        }
        let (least, most) = medians
            .iter()
            .fold((f64::MAX, 0.0_f64), |(l, m), x| (l.min(*x), m.max(*x)));
        let rises = medians[0] > 1.3 * medians[BANDS - 1];
        let below = medians[0] * if rises { HIDDEN * HIDDEN } else { 1.0 };
        let at = |bin: usize| {
            if bin < from {
                below
            } else {
                medians[((bin - from) / width).min(BANDS - 1)]
            }
        };
        Some(Self {
            density: (0..n)
                .map(|bin| at(bin) * bin_hz / (1.0 / (2.0 * interval_s) / n as f64))
                .collect(),
            sure: has_room && least > 0.0 && most < DISAGREE * least,
        })
    }

    /// `n` samples of noise with this density, the same on each call.
    pub fn sample(&self, n: usize, interval_s: f64) -> Vec<f64> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(1);
        let m = n.max(8);
        let mut bins = vec![Complex::new(0.0, 0.0); m];
        for k in 1..m.div_ceil(2) {
            let place = 2 * k * self.density.len() / m;
            let power = self.density[place.min(self.density.len() - 1)];
            // A tone per frequency: its mean square is half its amplitude squared, over a bin of 1 / (m h).
            let size = (0.5 * power / (m as f64 * interval_s)).sqrt();
            let phase = TAU * (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64;
            bins[k] = Complex::from_polar(size, phase);
            bins[m - k] = bins[k].conj();
        }
        fourier::inverse(m).process(&mut bins);
        bins[..n].iter().map(|c| c.re).collect()
    }
}

/// Lowers the densities of bands to their quiet values, if those are clearly lower.
fn quieten(
    densities: &mut [f64],
    edges: &[f64],
    residual: &[f64],
    (motion_hz, interval_s): (f64, f64),
) {
    // Wide enough to be quiet between two reversals.
    let wide = WIDE * motion_hz / (edges[1] - edges[0]);
    let together = (wide.ceil().max(1.0) as usize).min(densities.len());
    let crowded = wide > densities.len() as f64;
    for (i, group) in densities.chunks_mut(together).enumerate() {
        let first = i * together;
        let (low, high) = (edges[first], edges[first + group.len()]);
        let mut quiet = quiet::density(residual, interval_s, low, high).unwrap_or(f64::INFINITY);
        if crowded {
            quiet = quiet.min(quiet::of_differences(residual) * 2.0 * interval_s);
        }
        let mean = group.iter().sum::<f64>() / group.len() as f64;
        if quiet < ALIKE * mean {
            group.fill(quiet);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::signals::rms;
    use rand_distr::{Distribution, StandardNormal};

    /// A force of 40 s at 1 kHz: a motion of up to 4 Hz through a spring, and noise.
    fn record(noise: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let motion = |i: usize| {
            let t = i as f64 * 1e-3;
            5.0 * (TAU * (0.3 + 0.045 * t) * t).sin()
        };
        let x: Vec<f64> = (0..noise.len()).map(motion).collect();
        let y = x.iter().zip(noise).map(|(x, n)| 20.0 * x + n).collect();
        (x, y)
    }

    fn white(n: usize, seed: u64) -> Vec<f64> {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
        (0..n).map(|_| StandardNormal.sample(&mut random)).collect()
    }

    #[test]
    fn white_and_low_passed_noise_are_known_without_a_rest() {
        for seed in 0..20 {
            let flat = white(40_000, seed);
            let mut low = flat.clone();
            for i in 1..low.len() {
                low[i] += 0.4 * low[i - 1];
            }
            for noise in [flat, low] {
                let (x, y) = record(&noise);
                let found = Above::of(&y, &x, 1e-3, None).unwrap();
                let ratio = rms(&[found.sample(7000, 1e-3)]) / rms(&[noise]);
                assert!(found.sure && (1.0 / 1.3..1.3).contains(&ratio), "{ratio}");
            }
        }
    }

    #[test]
    fn harmonics_of_friction_are_no_noise_that_is_known() {
        let quiet: Vec<f64> = white(40_000, 7).iter().map(|n| 1e-3 * n).collect();
        let (x, mut y) = record(&quiet);
        for i in 1..y.len() {
            y[i] += 30.0 * (x[i] - x[i - 1]).signum();
        }
        assert!(!Above::of(&y, &x, 1e-3, None).unwrap().sure);
    }
}
