//! How earthquake laboratories move bearings, dampers, braces and walls. Displacement in mm on the 8 kHz grid.

use crate::draws::Draws;
use crate::fine::{DT, FINE_HZ, lag, peak};
use std::f64::consts::TAU;

/// A motion, and how it is recorded.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// mm
    pub(super) x: Vec<f64>,
    pub(super) rate_hz: f64,
    /// Rest before the motion, s.
    pub(super) rest_s: f64,
    pub(super) name: &'static str,
}

/// Rest after the motion, s.
pub(super) const AFTER_S: f64 = 1.0;

impl Motion {
    /// Cycles, sines or an earthquake with a largest displacement of `peak_mm`; `slow` is for specimens whose force hardly
    /// depends on speed.
    pub(super) fn draw(peak_mm: f64, slow: bool, rng: &mut Draws) -> Self {
        let rate_hz = if slow {
            rng.pick(&[50.0, 100.0])
        } else {
            rng.pick(&[100.0, 200.0, 250.0])
        };
        let rest_s = rng.pick(&[0.0, 2.0, 3.0, 5.0]);
        let kinds: &[&str] = if slow {
            &["cycles", "slow earthquake"]
        } else {
            &["cycles", "earthquake", "sines"]
        };
        let name = rng.pick(kinds);
        let moved = match name {
            "cycles" => growing_cycles(peak_mm, if slow { 0.25 } else { 2.0 }),
            "sines" => sines(peak_mm),
            "earthquake" => earthquake(peak_mm, rng.between(0.6, 2.0), 40.0, rng),
            _ => earthquake(peak_mm, 4.0, 100.0, rng),
        };
        let still = |seconds: f64| vec![0.0; (seconds * FINE_HZ) as usize];
        let x = [still(rest_s), moved, still(AFTER_S)].concat();
        Self {
            x: if name == "earthquake" || name == "slow earthquake" {
                x
            } else {
                // The actuator rounds off the corners.
                lag(&lag(&x, 0.02), 0.02)
            },
            rate_hz,
            rest_s,
            name,
        }
    }

    /// Length with the rests, s.
    pub(super) fn seconds(&self) -> f64 {
        self.x.len() as f64 * DT
    }
}

/// Triangle waves of growing and then changing size, all at the speed of `peaks_per_s` times `peak_mm` a second.
fn growing_cycles(peak_mm: f64, peaks_per_s: f64) -> Vec<f64> {
    let sizes = [
        (0.1, 3),
        (0.2, 3),
        (0.3, 3),
        (0.45, 2),
        (0.6, 2),
        (0.8, 2),
        (0.5, 2),
        (1.0, 2),
        (0.7, 2),
    ];
    let triangle = |phase: f64| 1.0 - 4.0 * ((phase + 0.25).fract() - 0.5).abs();
    let block = |(size, count): (f64, u32)| {
        let hz = peaks_per_s / (4.0 * size);
        let n = (f64::from(count) / hz * FINE_HZ) as usize;
        (0..n).map(move |i| -size * peak_mm * triangle(hz * i as f64 * DT))
    };
    sizes.into_iter().flat_map(block).collect()
}

/// Three cycles each at several sizes and frequencies, as in prototype tests of bearings and dampers.
fn sines(peak_mm: f64) -> Vec<f64> {
    let runs = [
        (0.25, 0.2),
        (0.5, 0.1),
        (0.5, 0.5),
        (1.0, 0.3),
        (0.75, 0.5),
        (0.5, 1.0),
        (0.9, 0.2),
        (0.35, 0.8),
    ];
    let block = |(size, hz): (f64, f64)| {
        let n = (3.0 / hz * FINE_HZ) as usize;
        (0..n).map(move |i| size * peak_mm * (TAU * hz * i as f64 * DT).sin())
    };
    runs.into_iter().flat_map(block).collect()
}

/// The displacement of an oscillator with 7 % damping under noise of 0.2 to 8 Hz that swells and fades.
fn earthquake(peak_mm: f64, period_s: f64, seconds: f64, rng: &mut Draws) -> Vec<f64> {
    let n = (seconds * FINE_HZ) as usize;
    let white: Vec<f64> = (0..n).map(|_| rng.normal()).collect();
    let low = |x: &[f64], hz: f64| lag(&lag(x, 1.0 / (TAU * hz)), 1.0 / (TAU * hz));
    let below = low(&white, 8.0);
    let slow = low(&below, 0.2);
    let omega = TAU / period_s;
    let (mut x, mut v) = (0.0, 0.0);
    let moved: Vec<f64> = (0..n)
        .map(|i| {
            let t = i as f64 * DT;
            let strength =
                (t / 3.0).min(1.0).powi(2) * (-(t - 8.0).max(0.0) / (seconds / 4.0)).exp();
            let ground = strength * (below[i] - slow[i]);
            v += DT * (-ground - 0.14 * omega * v - omega * omega * x);
            x += DT * v;
            x * ((seconds - t) / 2.0).min(1.0)
        })
        .collect();
    let by = peak_mm / peak(&moved).max(f64::MIN_POSITIVE);
    moved.into_iter().map(|x| by * x).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_and_earthquakes_reach_their_peak_and_begin_and_end_at_rest() {
        for seed in 0..40 {
            let rng = &mut Draws::new(seed);
            let motion = Motion::draw(30.0, seed % 2 == 0, rng);
            let reached = peak(&motion.x);
            assert!(
                (24.0..=30.001).contains(&reached),
                "{} {reached}",
                motion.name
            );
            assert!(motion.x[0].abs() < 1e-9);
            let end = motion.x[motion.x.len() - 1];
            assert!(end.abs() < 0.1, "{} {end}", motion.name);
        }
    }
}
