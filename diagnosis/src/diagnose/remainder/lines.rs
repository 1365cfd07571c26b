//! Coherent lines and wandering tones in a model's residual.

use crate::model::answer::Line;
use crate::record::spectrum::periodogram;

/// Widths, in bins, over which a tone may wander, and the required ratio of its mean to the running median: chance
/// gives one false alarm in some hundred records of noise.
const WIDTHS: [(usize, f64); 4] = [(1, 26.0), (4, 9.5), (16, 4.2), (64, 2.6)];
/// Bins to either side used for a running median, besides the width itself.
const AROUND: usize = 60;
/// The motion has its own line in bins above this fraction of its largest.
const OWN: f64 = 1e-4;
/// Its strongest bins, above this fraction of the largest, have harmonics.
const STRONG: f64 = 0.05;
/// Number of harmonics removed.
const HARMONICS: usize = 9;
/// Largest number of lines named.
const MOST: usize = 3;
/// Fraction of the squares below which a line does not matter.
const MATTERS: f64 = 0.02;

/// Bins that belong to the motion: its own, and the harmonics of its strong ones.
fn struck(motion: &[f64]) -> Vec<bool> {
    let power = periodogram(motion);
    let n = power.len();
    let largest = power.iter().fold(0.0_f64, |m, p| m.max(*p));
    let mut out = vec![false; n];
    let near = |out: &mut Vec<bool>, k: usize, room: usize| {
        for o in &mut out[k.saturating_sub(room).min(n)..(k + room + 1).min(n)] {
            *o = true;
        }
    };
    near(&mut out, 0, 3);
    for (k, p) in power.iter().enumerate() {
        if *p > OWN * largest {
            near(&mut out, k, 3);
        }
        if *p > STRONG * largest {
            for harmonic in 2..=HARMONICS {
                near(&mut out, harmonic * k, 2 + harmonic);
            }
        }
    }
    out
}

/// Largest wander of a tone, as a fraction of its frequency.
const WANDERS: f64 = 0.25;

/// Lines at standstill that are tones, strongest first: wider ones are the colour of the noise, for which a second or
/// two has only a few bins.
pub fn tones(still: &[f64], interval_s: f64) -> Vec<Line> {
    found(still, &vec![0.0; still.len()], interval_s, WANDERS)
}

/// Lines of a residual that do not belong to the motion, strongest first.
pub fn lines(rest: &[f64], motion: &[f64], interval_s: f64) -> Vec<Line> {
    found(rest, motion, interval_s, f64::INFINITY)
}

/// The same, of lines that wander by no more than a fraction of their frequency.
fn found(rest: &[f64], motion: &[f64], interval_s: f64, wanders: f64) -> Vec<Line> {
    let struck = struck(motion);
    // The bins that remain without the motion's own, in order, with their original indices.
    let all = periodogram(rest);
    let places: Vec<usize> = (0..all.len()).filter(|k| !struck[*k]).collect();
    let mut power: Vec<f64> = places.iter().map(|k| all[*k]).collect();
    let n = power.len();
    let whole: f64 = all.iter().sum();
    let bin_hz = 1.0 / (rest.len() as f64 * interval_s);
    let square = rest.iter().map(|r| r * r).sum::<f64>() / rest.len() as f64;
    let mut found = Vec::new();
    while found.len() < MOST && n > 4 * AROUND {
        let best = WIDTHS
            .iter()
            .filter(|(width, _)| 8 * width < n)
            .filter_map(|&(width, most)| {
                let too_low = |k: &usize| wanders * (*k as f64) < width as f64;
                let first = if width > 1 {
                    places.partition_point(too_low).saturating_sub(width / 2)
                } else {
                    0
                };
                let (at, times) = prominent(&power, width, first)?;
                (times > most).then_some((at, width, times / most))
            })
            .max_by(|a, b| a.2.total_cmp(&b.2));
        let Some((at, width, _)) = best else { break };
        // A Hann window spreads a line over three bins.
        let (from, end) = (at.saturating_sub(2), (at + width + 2).min(n));
        let medians = running_median(&power, at, width);
        let own: f64 = power[from..end]
            .iter()
            .map(|p| (p - medians).max(0.0))
            .sum();
        let weight: f64 = power[from..end].iter().sum();
        let centre: f64 = (from..end)
            .map(|k| places[k] as f64 * power[k])
            .sum::<f64>()
            / weight;
        power[from..end].iter_mut().for_each(|p| *p = medians);
        if own < MATTERS * whole {
            break;
        }
        found.push(Line {
            frequency_hz: centre * bin_hz,
            width_hz: width as f64 * bin_hz,
            rms: (square * own / whole).sqrt(),
            at_rest: false,
        });
    }
    found
}

/// Fraction of a line's rms that the signal itself must have there.
const THERE: f64 = 0.5;

/// True if a signal itself has a line: what a model makes of its input's noise, twice differentiated for a mass, is a
/// line of the model and not of the measurement.
pub fn is_in(line: &Line, signal: &[f64], interval_s: f64) -> bool {
    let power = periodogram(signal);
    let whole: f64 = power.iter().sum();
    let bin_hz = 1.0 / (signal.len() as f64 * interval_s);
    let square = signal.iter().map(|s| s * s).sum::<f64>() / signal.len().max(1) as f64;
    let near = |k: usize| {
        (k as f64 * bin_hz - line.frequency_hz).abs() <= 0.5 * line.width_hz + 2.0 * bin_hz
    };
    let here = power.iter().enumerate().filter(|(k, _)| near(*k));
    let own: f64 = here.map(|(_, p)| p).sum();
    (square * own / whole.max(f64::MIN_POSITIVE)).sqrt() >= THERE * line.rms
}

/// The position from `first` on where the mean over a width exceeds the running median most, and the ratio.
fn prominent(power: &[f64], width: usize, first: usize) -> Option<(usize, f64)> {
    let mut sum: f64 = power.get(first..first + width)?.iter().sum();
    let mut best: Option<(usize, f64)> = None;
    let mut median = f64::MIN_POSITIVE;
    for at in first..power.len() - width {
        // The median varies slowly.
        if (at - first).is_multiple_of(AROUND / 4) {
            median = running_median(power, at, width).max(f64::MIN_POSITIVE);
        }
        let times = sum / width as f64 / median;
        if best.is_none_or(|b| times > b.1) {
            best = Some((at, times));
        }
        sum += power[at + width] - power[at];
    }
    best
}

/// Mean of noise powers over their median.
const MEAN: f64 = 1.443;

/// Mean of the noise around a position, from the median there.
fn running_median(power: &[f64], at: usize, width: usize) -> f64 {
    let room = AROUND + 4 * width;
    let (from, end) = (
        at.saturating_sub(room),
        (at + width + room).min(power.len()),
    );
    let mut sorted = power[from..end].to_vec();
    let middle = sorted.len() / 2;
    let (_, median, _) = sorted.select_nth_unstable_by(middle, f64::total_cmp);
    MEAN * *median
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};
    use std::f64::consts::TAU;

    const H: f64 = 2e-3;

    fn noise(seed: u64, n: usize) -> Vec<f64> {
        let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut low = 0.0;
        (0..n)
            .map(|_| {
                let e: f64 = StandardNormal.sample(&mut random);
                low = 0.7 * low + e;
                low
            })
            .collect()
    }

    fn motion(n: usize) -> Vec<f64> {
        (0..n).map(|i| (TAU * 0.7 * i as f64 * H).sin()).collect()
    }

    #[test]
    fn the_colour_of_noise_is_no_line_of_a_short_rest() {
        // A second and a half of noise below 20 Hz, with white noise, and below the ripple of a pump that hunts by 3 %.
        let (h, n) = (5e-4, 3000);
        let mut alarms = 0;
        for seed in 0..60 {
            let mut random = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
            let mut next = || -> f64 { StandardNormal.sample(&mut random) };
            let (keep, mut low) = (f64::exp(-TAU * 20.0 * h), 0.0);
            let mut rest = Vec::new();
            for _ in 0..n + 1000 {
                low = keep * low + next();
                rest.push(0.9 * (1.0 - keep * keep).sqrt() * low + next());
            }
            rest.drain(..1000);
            alarms += usize::from(!tones(&rest, h).is_empty());
            let ripple = |i: usize| {
                let t = i as f64 * h;
                2.0 * (TAU * 62.0 * t + 0.03 * 62.0 / 0.9 * (TAU * 0.9 * t).sin()).sin()
            };
            let with: Vec<f64> = rest
                .iter()
                .enumerate()
                .map(|(i, r)| r + ripple(i))
                .collect();
            let found = tones(&with, h);
            let near = found.iter().any(|l| (l.frequency_hz - 62.0).abs() < 3.0);
            assert!(near, "{seed}: {found:?}");
        }
        assert!(alarms <= 3, "{alarms} of 60 rests of noise");
    }

    #[test]
    fn a_ripple_that_wanders_is_found_and_noise_and_harmonics_of_the_motion_are_not() {
        let n = 15_000;
        let moves = motion(n);
        let mut alarms = 0;
        for seed in 0..60 {
            let mut rest = noise(seed, n);
            // Harmonics of friction at a reversal.
            for (r, v) in rest
                .iter_mut()
                .zip(crate::numbers::signals::derivative(&moves, H))
            {
                *r += 3.0 * v.signum();
            }
            alarms += usize::from(!lines(&rest, &moves, H).is_empty());
            // A pump at 23 Hz whose speed hunts by 2 %.
            let mut phase = 0.0;
            let ripple = |i: usize| {
                phase += TAU * (23.0 + 0.4 * (0.9 * i as f64 * H).sin()) * H;
                1.2 * f64::sin(phase)
            };
            let with: Vec<f64> = rest
                .iter()
                .zip((0..n).map(ripple))
                .map(|(r, p)| r + p)
                .collect();
            let found = lines(&with, &moves, H);
            assert!(
                found.iter().any(|l| (l.frequency_hz - 23.0).abs() < 1.0),
                "{seed}: {found:?}"
            );
        }
        assert!(alarms <= 2, "{alarms} of 60 records of noise");
    }
}
