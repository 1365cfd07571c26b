//! A signal below a cut-off, with its derivatives.

use crate::numbers::signals::derivative;
use fourier::Complex;
use std::f64::consts::{PI, TAU};

/// Displacement, velocity and acceleration, mm, mm/s, mm/s^2.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Displacement.
    pub x: Vec<f64>,
    /// Velocity.
    pub v: Vec<f64>,
    /// Acceleration.
    pub a: Vec<f64>,
}

impl Motion {
    /// From a displacement without noise.
    pub fn of(x: &[f64], interval_s: f64) -> Self {
        let v = derivative(x, interval_s);
        let a = derivative(&v, interval_s);
        Self {
            x: x.to_vec(),
            v,
            a,
        }
    }
}

/// The discrete Fourier transform of a signal's odd reflection, whose ends meet with equal slope.
#[derive(Debug)]
pub struct Reflected {
    /// Without the line.
    bins: Vec<Complex<f64>>,
    /// Points before the first sample.
    before: usize,
    samples: usize,
    interval_s: f64,
    /// The straight line from end to end that closes the period: its start, and its rise per point.
    line: [f64; 2],
}

impl Reflected {
    /// Reflects at least `least` samples at each end, as far as there are so many.
    pub fn of(x: &[f64], interval_s: f64, least: usize) -> Self {
        let (n, most) = (x.len(), x.len() - 1);
        let least = least.min(most);
        let points = fourier::quick_length(n + 2 * least).min(n + 2 * most);
        let before = (points - n) / 2;
        let odd = |end: f64, inner: f64| 2.0 * end - inner;
        let mut series: Vec<f64> = (1..=before).rev().map(|i| odd(x[0], x[i])).collect();
        series.extend_from_slice(x);
        let after = points - n - before;
        series.extend((1..=after).map(|i| odd(x[most], x[most - i])));
        let rise = (series[points - 1] - series[0]) / (points - 1) as f64;
        let line = [series[0], rise];
        let rest = |(i, s): (usize, &f64)| Complex::new(s - line[0] - rise * i as f64, 0.0);
        let mut bins: Vec<Complex<f64>> = series.iter().enumerate().map(rest).collect();
        fourier::forward(points).process(&mut bins);
        Self {
            bins,
            before,
            samples: n,
            interval_s,
            line,
        }
    }

    /// Power up to half the sampling rate.
    pub fn power(&self) -> Vec<f64> {
        let half = &self.bins[..self.bins.len() / 2];
        half.iter().map(Complex::norm_sqr).collect()
    }

    /// Frequency of a bin, negative above half the sampling rate.
    pub fn hz(&self, bin: usize) -> f64 {
        let (k, m) = (bin as f64, self.bins.len() as f64);
        (if 2 * bin <= self.bins.len() { k } else { k - m }) / (m * self.interval_s)
    }

    /// The signal behind a zero-phase filter of this gain over frequency, Hz.
    pub fn filtered(&self, gain: impl Fn(f64) -> f64) -> Vec<f64> {
        let x = self.transformed(1, &gain, |_| Complex::new(1.0, 0.0));
        self.on_the_line(x.iter().map(|c| c.re), 1)
    }

    /// The same with its derivatives, with `fine` samples per sample of the signal: a motion may also reverse between
    /// two samples.
    pub fn motion(&self, gain: impl Fn(f64) -> f64, fine: usize) -> Motion {
        // Two real signals in one transform: displacement and i times velocity.
        let both = self.transformed(fine, &gain, |s| {
            Complex::new(1.0, 0.0) + Complex::new(0.0, 1.0) * s
        });
        let third = self.transformed(fine, &gain, |s| s * s);
        let speed = self.line[1] / self.interval_s;
        Motion {
            x: self.on_the_line(both.iter().map(|c| c.re), fine),
            v: both.iter().map(|c| c.im + speed).collect(),
            a: third.iter().map(|c| c.re).collect(),
        }
    }

    fn on_the_line(&self, x: impl Iterator<Item = f64>, fine: usize) -> Vec<f64> {
        let [first, rise] = self.line;
        let at = |i: usize| first + rise * (i as f64 / fine as f64 + self.before as f64);
        x.enumerate().map(|(i, x)| x + at(i)).collect()
    }

    /// The samples after each bin was multiplied by its gain and by a function of its `i omega`.
    fn transformed(
        &self,
        fine: usize,
        gain: impl Fn(f64) -> f64,
        by: impl Fn(Complex<f64>) -> Complex<f64>,
    ) -> Vec<Complex<f64>> {
        let m = self.bins.len();
        let mut bins = vec![Complex::default(); m * fine];
        for (k, bin) in self.bins.iter().enumerate() {
            let hz = self.hz(k);
            let pass = gain(hz.abs()) / m as f64;
            if pass == 0.0 {
                continue;
            }
            // The bin at half the rate has no sign: its odd derivatives are zero, and it stands at both signs.
            let omega = if 2 * k == m { 0.0 } else { TAU * hz };
            let mut filtered = bin * pass * by(Complex::new(0.0, omega));
            if 2 * k == m && fine > 1 {
                filtered *= 0.5;
                bins[m * fine - k] = filtered;
            }
            let at = if 2 * k <= m { k } else { k + m * (fine - 1) };
            bins[at] = filtered;
        }
        fourier::inverse(m * fine).process(&mut bins);
        let first = self.before * fine;
        bins.truncate(first + (self.samples - 1) * fine + 1);
        bins.split_off(first)
    }
}

/// Gain of a low-pass over frequency: 1 up to the first of two multiples of its cut-off, 0 from the second on, with half a
/// cosine between. An infinite cut-off passes everything.
pub fn low_pass(cutoff_hz: f64, between: [f64; 2]) -> impl Fn(f64) -> f64 {
    let [from, to] = between;
    move |hz| match (hz / cutoff_hz - from) / (to - from) {
        r if r <= 0.0 => 1.0,
        r if r >= 1.0 => 0.0,
        r => 0.5 * (1.0 + (PI * r).cos()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_infinite_cut_off_passes_everything() {
        let x = [1.0, 3.0, -2.0, 5.0, 4.0, 4.5, 0.0];
        let same = Reflected::of(&x, 1e-3, 2).filtered(low_pass(f64::INFINITY, [0.7, 1.3]));
        for (x, same) in x.iter().zip(&same) {
            assert!((x - same).abs() < 1e-12, "{x} {same}");
        }
    }
}
