//! A displacement below a cut-off, with its derivatives, and the band of its motion.

use super::curvature;
use crate::criteria::BAND_POWER;
use crate::record::spectrum::Motion;
use fourier::Complex;
use std::f64::consts::{PI, TAU};

/// Above the cut-off the gain falls to 0 over this fraction of it, by half a cosine.
const FALL: f64 = 0.15;
/// Largest fraction of a signal that is mirrored at each end.
const MIRRORED: f64 = 0.25;

/// Width of a bend's fading, as a fraction of a cycle of the band's end: if it were shorter, the remainder would have
/// corners that no cut-off passes.
const FADES: f64 = 0.35;
/// Largest width, as a fraction of the record: what bends one end is gone at the other.
const LONGEST: f64 = 0.15;
/// Widths beyond which a bend is zero.
const GONE: f64 = 6.0;

/// The discrete Fourier transform of a displacement, mirrored at its ends with equal slope.
#[derive(Debug)]
pub struct Band {
    bins: Vec<Complex<f64>>,
    pad: usize,
    n: usize,
    interval_s: f64,
    first: f64,
    slope: f64,
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

    /// The transform of the signal without the bends.
    fn without(x: &[f64], interval_s: f64, bends: [Bend; 2]) -> Self {
        let n = x.len();
        let straight = |(i, x): (usize, &f64)| {
            let t = i as f64 * interval_s;
            x - bends.iter().map(|b| b.over(t)[0]).sum::<f64>()
        };
        let x: Vec<f64> = x.iter().enumerate().map(straight).collect();
        let least = ((MIRRORED * n as f64) as usize).min(n - 1);
        let pad = (smooth_length(n + least) - n) / 2;
        let pad = pad.min(n - 1);
        let mut series: Vec<f64> = (1..=pad).rev().map(|i| 2.0 * x[0] - x[i]).collect();
        series.extend_from_slice(&x);
        series.extend((1..=pad).map(|i| 2.0 * x[n - 1] - x[n - 1 - i]));
        let m = series.len();
        // Remove a straight line from end to end, so that the period closes.
        let (first, slope) = (series[0], (series[m - 1] - series[0]) / (m - 1) as f64);
        let line = |(i, s): (usize, &f64)| Complex::new(s - first - slope * i as f64, 0.0);
        let mut bins: Vec<Complex<f64>> = series.iter().enumerate().map(line).collect();
        fourier::forward(m).process(&mut bins);
        Self {
            bins,
            pad,
            n,
            interval_s,
            first,
            slope,
            bends,
        }
    }

    fn hz(&self, k: usize) -> f64 {
        let m = self.bins.len();
        let signed = if 2 * k <= m {
            k as f64
        } else {
            k as f64 - m as f64
        };
        signed / (m as f64 * self.interval_s)
    }

    /// Displacement, velocity and acceleration below the cut-off, with `fine` samples per sample of the record: a
    /// motion may also reverse between two samples.
    pub fn motion(&self, cutoff_hz: f64, fine: usize) -> Motion {
        let m = self.bins.len();
        let nyquist = 0.5 / self.interval_s;
        let mut both = vec![Complex::default(); m * fine];
        let mut third = vec![Complex::default(); m * fine];
        for (k, bin) in self.bins.iter().enumerate() {
            let hz = self.hz(k);
            let pass = gain(hz.abs() / cutoff_hz) / m as f64;
            if pass == 0.0 {
                continue;
            }
            // The bin at half the rate has no sign: its odd derivatives are zero.
            let omega = if hz.abs() < nyquist * (1.0 - 1e-9) {
                TAU * hz
            } else {
                0.0
            };
            let x = bin * pass;
            let v = x * Complex::new(0.0, omega);
            let at = if 2 * k <= m { k } else { k + m * (fine - 1) };
            // Two real signals in one transform: displacement and i times velocity.
            both[at] = x + Complex::new(0.0, 1.0) * v;
            third[at] = v * Complex::new(0.0, omega);
        }
        let plan = fourier::inverse(m * fine);
        plan.process(&mut both);
        plan.process(&mut third);
        let here = self.pad * fine..(self.pad + self.n - 1) * fine + 1;
        let line = |i: usize| self.first + self.slope * (i as f64 / fine as f64 + self.pad as f64);
        let speed = self.slope / self.interval_s;
        let mut motion = Motion {
            x: both[here.clone()]
                .iter()
                .enumerate()
                .map(|(i, c)| c.re + line(i))
                .collect(),
            v: both[here.clone()].iter().map(|c| c.im + speed).collect(),
            a: third[here].iter().map(|c| c.re).collect(),
        };
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
        let half = self.bins.len() / 2;
        let power: Vec<f64> = self.bins[..half].iter().map(Complex::norm_sqr).collect();
        let mut upper = power[half / 2..].to_vec();
        upper.sort_by(f64::total_cmp);
        // The mean of an exponential distribution is 1.44 times its median.
        let noise = 1.44 * upper[upper.len() / 2];
        let speeds: Vec<f64> = power
            .iter()
            .enumerate()
            .map(|(k, p)| (p - noise).max(0.0) * self.hz(k).powi(2))
            .collect();
        let whole: f64 = speeds.iter().sum();
        let mut sum = 0.0;
        for (k, s) in speeds.iter().enumerate() {
            sum += s;
            if sum >= BAND_POWER * whole {
                return self.hz(k.max(1));
            }
        }
        self.hz(half)
    }
}

/// 1 up to the cut-off, 0 from 1.15 of it on, with half a cosine between.
fn gain(relative: f64) -> f64 {
    match (relative - 1.0) / FALL {
        r if r <= 0.0 => 1.0,
        r if r >= 1.0 => 0.0,
        r => 0.5 * (1.0 + (PI * r).cos()),
    }
}

/// The next length with a fast transform: no prime factor above 5.
fn smooth_length(least: usize) -> usize {
    let quick = |n: &usize| {
        let mut n = *n;
        for p in [2_usize, 3, 5] {
            while n.is_multiple_of(p) {
                n /= p;
            }
        }
        n == 1
    };
    (least..).find(quick).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::*;

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
