//! A measured displacement without its noise, with its derivatives: the input of the forces.

use crate::numbers::reflected::{Motion, Reflected, low_pass};
use fourier::Complex;
use std::f64::consts::TAU;

/// Where the low-pass begins and where it ends, in parts of its cut-off: hardly any ringing.
const FALLS: [f64; 2] = [0.7, 1.3];

fn reflected(x: &[f64], interval_s: f64, cutoff_hz: f64) -> Reflected {
    Reflected::of(x, interval_s, (2.0 / interval_s / cutoff_hz) as usize + 8)
}

/// Zero-phase low-pass and derivatives of `x`. `cutoff_hz` is the frequency at which the amplitude has fallen to a half.
pub fn smooth(x: &[f64], interval_s: f64, cutoff_hz: f64) -> Motion {
    reflected(x, interval_s, cutoff_hz).motion(low_pass(cutoff_hz, FALLS), 1)
}

/// Zero-phase low-pass of `x`, as [`smooth`].
pub fn low_passed(x: &[f64], interval_s: f64, cutoff_hz: f64) -> Vec<f64> {
    reflected(x, interval_s, cutoff_hz).filtered(low_pass(cutoff_hz, FALLS))
}

/// The frequency above which `x` is only noise of `noise_rms`, Hz; between 5 Hz and 0.3 of the sampling rate.
pub fn bandwidth_hz(x: &[f64], interval_s: f64, noise_rms: f64) -> f64 {
    let (n, rate) = (x.len(), 1.0 / interval_s);
    let mean = x.iter().sum::<f64>() / n as f64;
    let hann = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
    let mut bins: Vec<Complex<f64>> = (0..n)
        .map(|i| Complex::new((x[i] - mean) * hann(i), 0.0))
        .collect();
    fourier::forward(n).process(&mut bins);
    // Expected power of white noise in a bin, under the window's mean square of 3/8.
    let expected = noise_rms * noise_rms * n as f64 * 0.375;
    let power: Vec<f64> = bins[..n / 2].iter().map(Complex::norm_sqr).collect();
    let width = (n / 400).max(4);
    let mut last = 0;
    for (block, p) in power.chunks(width).enumerate() {
        if p.iter().sum::<f64>() / p.len() as f64 > 6.0 * expected {
            last = block + 1;
        }
    }
    let edge = (last * width) as f64 * rate / n as f64;
    (1.5 * edge).clamp(5.0_f64.min(0.3 * rate), 0.3 * rate)
}

/// Number of windows averaged in a periodogram.
const WINDOWS: usize = 30;

/// An averaged periodogram.
#[derive(Clone, Debug)]
pub struct Density {
    /// Power over frequency, unit^2 / Hz, one-sided.
    pub power: Vec<f64>,
    /// Bin width, Hz.
    pub bin_hz: f64,
}

impl Density {
    /// Half-overlapping Hann windows, each without its mean; `None` if the record is too short for them.
    pub fn of(x: &[f64], interval_s: f64) -> Option<Self> {
        let length = 2 * x.len() / (WINDOWS + 1);
        if length < 16 {
            return None;
        }
        let hann = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / length as f64).cos();
        let plan = fourier::forward(length);
        let mut power = vec![0.0; length / 2];
        let mut windows = 0.0;
        for start in (0..=x.len() - length).step_by(length / 2) {
            let part = &x[start..start + length];
            let mean = part.iter().sum::<f64>() / length as f64;
            let mut bins: Vec<Complex<f64>> = part
                .iter()
                .enumerate()
                .map(|(i, x)| Complex::new((x - mean) * hann(i), 0.0))
                .collect();
            plan.process(&mut bins);
            for (sum, bin) in power.iter_mut().zip(&bins) {
                *sum += bin.norm_sqr();
            }
            windows += 1.0;
        }
        // The window's mean square is 3/8.
        let scale = 2.0 * interval_s / (0.375 * length as f64 * windows);
        power.iter_mut().for_each(|p| *p *= scale);
        Some(Self {
            power,
            bin_hz: 1.0 / (length as f64 * interval_s),
        })
    }
}

/// Power of each bin up to half the rate, under a Hann window.
pub fn periodogram(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mean = x.iter().sum::<f64>() / n as f64;
    let hann = |i: usize| 0.5 - 0.5 * (TAU * i as f64 / n as f64).cos();
    let mut bins: Vec<Complex<f64>> = x
        .iter()
        .enumerate()
        .map(|(i, x)| Complex::new((x - mean) * hann(i), 0.0))
        .collect();
    fourier::forward(n).process(&mut bins);
    bins[..n / 2].iter().map(Complex::norm_sqr).collect()
}

/// Fraction of the speed's power below the band's end.
const BAND: f64 = 0.9;
/// What exceeds the floor of a reading by less than this is its noise.
const FLOOR: f64 = 6.0;
/// Power of a converter's steps relative to an even distribution of its error: holding between two steps adds power.
const STEPS: f64 = 2.0;

/// Upper end of the motion's band: 90 % of its speed's power lie below, Hz; without the noise of its reading.
pub fn motion_band_hz(x: &[f64], interval_s: f64) -> Option<f64> {
    let Density { power, bin_hz } = Density::of(x, interval_s)?;
    let mut upper = power[power.len() / 2..].to_vec();
    upper.sort_by(f64::total_cmp);
    let floor = FLOOR * upper[upper.len() / 2];
    // Nor is it motion if it has no more power than converter steps make; for a ramp these are lines.
    let steps = crate::record::converter_step::step(x).map_or(0.0, |q| STEPS * q * q / 12.0);
    let mut above = 0.0;
    let last = power.iter().rposition(|p| {
        above += p * bin_hz;
        above > steps
    })?;
    let speed: Vec<f64> = power[..=last]
        .iter()
        .enumerate()
        .map(|(k, p)| if *p > floor { p * (k * k) as f64 } else { 0.0 })
        .collect();
    let whole: f64 = speed.iter().sum();
    let mut below = 0.0;
    let end = speed.iter().position(|p| {
        below += p;
        below >= BAND * whole
    })?;
    Some((end + 1) as f64 * bin_hz)
}

/// Frequency of the strongest line between two frequencies, and its power over the median there.
pub fn line_hz(x: &[f64], interval_s: f64, from_hz: f64, to_hz: f64) -> Option<(f64, f64)> {
    let n = x.len();
    let bin_hz = 1.0 / (n as f64 * interval_s);
    let (first, end) = ((from_hz / bin_hz) as usize, (to_hz / bin_hz) as usize + 1);
    if end >= n / 2 || end < first + 4 {
        return None;
    }
    let mean = x.iter().sum::<f64>() / n as f64;
    let mut bins: Vec<Complex<f64>> = x.iter().map(|x| Complex::new(x - mean, 0.0)).collect();
    fourier::forward(n).process(&mut bins);
    let power: Vec<f64> = bins[first..end].iter().map(Complex::norm_sqr).collect();
    let best = (0..power.len()).max_by(|a, b| power[*a].total_cmp(&power[*b]))?;
    let mut sorted = power.clone();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2].max(f64::MIN_POSITIVE);
    Some(((first + best) as f64 * bin_hz, power[best] / median))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn derivatives_of_a_sine_are_a_cosine_and_a_sine() {
        let (dt, w) = (1e-3, TAU * 3.3);
        let x: Vec<f64> = (0..5000).map(|i| 2.0 + (w * i as f64 * dt).sin()).collect();
        let m = smooth(&x, dt, 40.0);
        for i in 300..4700 {
            let t = w * i as f64 * dt;
            assert!((m.x[i] - 2.0 - t.sin()).abs() < 1e-4, "{i}");
            assert!((m.v[i] / w - t.cos()).abs() < 1e-3, "{i}");
            assert!((m.a[i] / w / w + t.sin()).abs() < 1e-2, "{i}");
        }
    }

    #[test]
    fn bandwidth_and_lines_are_found() {
        let dt = 1e-3;
        let mut rng =
            <rand_xoshiro::Xoshiro256PlusPlus as rand_core::SeedableRng>::seed_from_u64(3);
        let mut noise = move |_: usize| -> f64 {
            1e-3 * Distribution::<f64>::sample(&StandardNormal, &mut rng)
        };
        let x: Vec<f64> = (0..8000)
            .map(|i| (TAU * 12.0 * i as f64 * dt).sin() + noise(i))
            .collect();
        let edge = bandwidth_hz(&x, dt, 1e-3);
        assert!((12.0..40.0).contains(&edge), "{edge}");
        let hum: Vec<f64> = (0..8000)
            .map(|i| (TAU * 50.3 * i as f64 * dt).sin() + 100.0 * noise(i))
            .collect();
        let (hz, prominence) = line_hz(&hum, dt, 45.0, 65.0).unwrap();
        assert!(
            (hz - 50.3).abs() < 0.13 && prominence > 50.0,
            "{hz} {prominence}"
        );
    }
}
