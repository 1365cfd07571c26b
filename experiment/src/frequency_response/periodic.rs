//! Distortion of a periodic command with odd lines alone: what is on its even lines is of even order, what is on odd lines
//! that it leaves out is of odd order, and what is between the lines is noise.

use super::distortion::{Distortion, DistortionLine, Excitation};
use fourier::Complex;

/// A command repeats itself where it differs from that of a period before by less than this share, rms.
const REPEATS: f64 = 0.02;
/// Shortest period, s, and fewest whole periods behind the first, which is still settling.
const SHORTEST_S: f64 = 1.0;
const FEWEST_PERIODS: usize = 2;
/// The end of a record, s, in which the command fades.
const FADES_S: f64 = 1.0;
/// A line that has less than this share of the largest one's amplitude is no line of the command.
const LEAST_LINE: f64 = 3e-3;

/// `None` of a command that does not repeat itself, or that has even lines of its own.
pub fn distortion(command: &[f64], displacement: &[f64], interval_s: f64) -> Option<Distortion> {
    let fades = (FADES_S / interval_s).ceil() as usize;
    let period = period(command, (SHORTEST_S / interval_s) as usize, fades)?;
    // The first period settles, the end fades.
    let whole = command.len().checked_sub(period + fades)? / period;
    if whole < FEWEST_PERIODS {
        return None;
    }
    let start = period;
    let span = start..start + whole * period;
    let [u, y] = [command, displacement].map(|x| amplitudes(&x[span.clone()]));
    let line = |h: usize| h * whole;
    let last = (period / 2).min((u.len() - whole) / whole);
    let largest = (1..last).map(|h| u[line(h)]).fold(0.0, f64::max);
    let driven = |h: usize| u[line(h)] > LEAST_LINE * largest;
    let top = (1..last).rev().find(|h| driven(*h))?;
    let even_lines = (1..=top).filter(|h| h % 2 == 0 && driven(*h)).count();
    if even_lines > 0 || top < 5 {
        return None;
    }
    // Power of noise at a line: the mean between it and its neighbours.
    let noise_at = |h: usize| {
        let between = (1..whole).flat_map(|i| [line(h) - i, line(h) + i]);
        let squares: f64 = between.map(|k| y[k] * y[k]).sum();
        (squares / (2 * (whole - 1)) as f64).sqrt()
    };
    let rms = std::f64::consts::FRAC_1_SQRT_2;
    let lines = (1..=top)
        .map(|h| DistortionLine {
            hz: h as f64 / (period as f64 * interval_s),
            linear_mm: if driven(h) { rms * y[line(h)] } else { 0.0 },
            even_mm: (h % 2 == 0).then(|| rms * y[line(h)]),
            odd_mm: (h % 2 == 1 && !driven(h)).then(|| rms * y[line(h)]),
            noise_mm: rms * noise_at(h),
        })
        .collect();
    Some(Distortion {
        excitation: Excitation::OddMultisine,
        lines,
    })
}

/// Samples of a period: the shortest shift by which the command is itself again.
fn period(command: &[f64], shortest: usize, fades: usize) -> Option<usize> {
    let inner = command.get(fades..command.len().checked_sub(fades)?)?;
    let longest = inner.len() / FEWEST_PERIODS;
    let power = inner.iter().map(|x| x * x).sum::<f64>() / inner.len() as f64;
    // Some hundred samples tell which shifts are worth a whole look.
    let stride = (inner.len() / 500).max(1);
    let difference = |shift: usize, stride: usize| {
        let pairs = inner.iter().zip(&inner[shift..]).step_by(stride);
        let (sum, n) = pairs.fold((0.0, 0.0), |(s, n), (a, b)| (s + (a - b).powi(2), n + 1.0));
        sum / n
    };
    let same = |shift: &usize| {
        let most = REPEATS * REPEATS * power;
        difference(*shift, stride) <= most && difference(*shift, 1) <= most
    };
    let first = (shortest.max(1)..longest).find(same)?;
    // A sample or two before the period a smooth command is nearly itself: the best of those that are follows.
    (first..longest)
        .take_while(same)
        .min_by(|a, b| difference(*a, 1).total_cmp(&difference(*b, 1)))
}

/// Amplitudes of a record's lines, up to half of its rate.
fn amplitudes(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mut bins: Vec<Complex<f64>> = x.iter().map(|x| Complex::new(*x, 0.0)).collect();
    fourier::forward(n).process(&mut bins);
    bins.iter()
        .take(n / 2)
        .map(|b| 2.0 * b.norm() / n as f64)
        .collect()
}
