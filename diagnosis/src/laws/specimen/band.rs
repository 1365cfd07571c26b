//! A displacement below a cut-off, with its derivatives, and the band of its motion.

use super::curvature;
use crate::criteria::BAND_POWER;
use crate::numbers::reflected::{Motion, Reflected, low_pass};

/// Above the cut-off the gain falls to 0 over this fraction of it.
const FALL: f64 = 0.15;
/// Fraction of a signal that is mirrored at each end.
const MIRRORED: f64 = 0.125;

/// Width of a bend's fading, as a fraction of a cycle of the band's end: if it were shorter, the remainder would have
/// corners that no cut-off passes.
const FADES: f64 = 0.35;
/// Largest width, as a fraction of the record: what bends one end is gone at the other.
const LONGEST: f64 = 0.15;
/// Widths beyond which a bend is zero.
const GONE: f64 = 6.0;

/// A displacement, mirrored at its ends with equal slope and curvature.
#[derive(Debug)]
pub struct Band {
    /// Without the bends.
    mirrored: Reflected,
    interval_s: f64,
    bends: [Bend; 2],
}

/// Curvature of a signal at one of its ends: `a t^2 / 2`, fading within a fraction of a cycle. Without it a mirror
/// image would reverse the acceleration there.
#[derive(Clone, Copy, Debug, Default)]
struct Bend {
    /// Its time, s.
    at_s: f64,
    /// Second derivative there.
    acceleration: f64,
    /// Width of its fading, s: by 1/e.
    width_s: f64,
}

impl Bend {
    /// Value, first and second derivative.
    fn over(&self, t_s: f64) -> [f64; 3] {
        let u = (t_s - self.at_s) / self.width_s;
        if u.abs() > GONE || self.acceleration == 0.0 {
            return [0.0; 3];
        }
        // a t^2 / 2 exp(-u^2).
        let fades = self.acceleration * (-u * u).exp();
        let t = t_s - self.at_s;
        [
            0.5 * fades * t * t,
            fades * t * (1.0 - u * u),
            fades * (1.0 - 5.0 * u * u + 2.0 * u.powi(4)),
        ]
    }
}

impl Band {
    pub fn new(x: &[f64], interval_s: f64) -> Self {
        let end_s = (x.len() - 1) as f64 * interval_s;
        let mirrored = Self::without(x, interval_s, [Bend::default(); 2]);
        let width_s = (FADES / mirrored.of_motion_hz()).min(LONGEST * end_s);
        // So few samples in part of a cycle cannot determine its curvature.
        if width_s < curvature::SHORTEST as f64 * interval_s {
            return mirrored;
        }
        let reverse: Vec<f64> = x.iter().rev().copied().collect();
        let bend = |x: &[f64], at_s| Bend {
            at_s,
            acceleration: curvature::at_the_start(x, interval_s),
            width_s,
        };
        let bends = [bend(x, 0.0), bend(&reverse, end_s)];
        Self::without(x, interval_s, bends)
    }

    fn without(x: &[f64], interval_s: f64, bends: [Bend; 2]) -> Self {
        let straight = |(i, x): (usize, &f64)| {
            let t = i as f64 * interval_s;
            x - bends.iter().map(|b| b.over(t)[0]).sum::<f64>()
        };
        let least = (MIRRORED * x.len() as f64) as usize;
        let x: Vec<f64> = x.iter().enumerate().map(straight).collect();
        Self {
            mirrored: Reflected::of(&x, interval_s, least),
            interval_s,
            bends,
        }
    }

    /// Displacement, velocity and acceleration below the cut-off, with `fine` samples per sample of the record.
    pub fn motion(&self, cutoff_hz: f64, fine: usize) -> Motion {
        let low_pass = low_pass(cutoff_hz, [1.0, 1.0 + FALL]);
        let mut motion = self.mirrored.motion(low_pass, fine);
        for i in 0..motion.x.len() {
            let t = i as f64 * self.interval_s / fine as f64;
            for bend in &self.bends {
                let [x, v, a] = bend.over(t);
                motion.x[i] += x;
                motion.v[i] += v;
                motion.a[i] += a;
            }
        }
        motion
    }

    /// Frequency below which nine tenths of the speed's power lie, Hz; the level of the upper half of the spectrum is
    /// taken as the sensor's noise.
    pub fn of_motion_hz(&self) -> f64 {
        let power = self.mirrored.power();
        let half = power.len();
        let mut upper = power[half / 2..].to_vec();
        upper.sort_by(f64::total_cmp);
        // The mean of an exponential distribution is 1.44 times its median.
        let noise = 1.44 * upper[upper.len() / 2];
        let speeds: Vec<f64> = power
            .iter()
            .enumerate()
            .map(|(k, p)| (p - noise).max(0.0) * self.mirrored.hz(k).powi(2))
            .collect();
        let whole: f64 = speeds.iter().sum();
        let mut sum = 0.0;
        for (k, s) in speeds.iter().enumerate() {
            sum += s;
            if sum >= BAND_POWER * whole {
                return self.mirrored.hz(k.max(1));
            }
        }
        self.mirrored.hz(half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_motion_that_begins_and_ends_at_its_crest_has_its_acceleration_there() {
        let (h, w) = (2e-3, TAU * 0.7);
        let x: Vec<f64> = (0..5001).map(|i| 10.0 * (w * i as f64 * h).cos()).collect();
        let m = Band::new(&x, h).motion(8.0, 1);
        for i in (0..25).chain(4976..5001) {
            // A mirror image alone has none at the end: 100 % off. The remainder rings at the cut-off and decays.
            let off = (m.a[i] + w * w * x[i]) / (w * w * 10.0);
            assert!(off.abs() < 0.1, "{i}: {off}");
            assert!((m.x[i] - x[i]).abs() < 0.01, "{i}");
        }
    }

    #[test]
    fn derivatives_of_a_swept_sine_are_those_of_its_equation() {
        let h = 1e-3;
        let phase = |t: f64| TAU * (0.5 * t + 0.4 * t * t);
        let rate = |t: f64| TAU * (0.5 + 0.8 * t);
        let t: Vec<f64> = (0..9001).map(|i| i as f64 * h).collect();
        let x: Vec<f64> = t.iter().map(|t| 3.0 + 5.0 * phase(*t).sin()).collect();
        let band = Band::new(&x, h);
        let m = band.motion(40.0, 1);
        for i in (1500..7500).step_by(250) {
            let (s, c) = phase(t[i]).sin_cos();
            let v = 5.0 * rate(t[i]) * c;
            let a = 5.0 * (TAU * 0.8 * c - rate(t[i]).powi(2) * s);
            assert!((m.x[i] - x[i]).abs() < 1e-3, "{i}");
            assert!((m.v[i] - v).abs() < 2e-3 * 5.0 * rate(t[i]), "{i}");
            assert!((m.a[i] - a).abs() < 1e-2 * 5.0 * rate(t[i]).powi(2), "{i}");
        }
        assert!(
            (5.0..8.0).contains(&band.of_motion_hz()),
            "{}",
            band.of_motion_hz()
        );
    }
}
