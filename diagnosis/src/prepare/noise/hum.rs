//! Mains hum in the reading of a displacement: it comes from the sensor, and the specimen does not move with it.
//!
//! It has harmonics, and its size and phase wander with other loads on the mains. What a single line of constant size
//! leaves of it would be taken for motion, and grows with the square of its frequency as an inertia force.

use super::{PROMINENT, between_bins, quadratures, without_trend};
use crate::numbers::linear::{dot, gram};
use crate::record::recording::Recording;
use crate::record::spectrum::line_hz;
use nalgebra::DVector;
use std::f64::consts::TAU;

/// Range of the mains line, Hz.
pub const MAINS_HZ: [f64; 2] = [44.0, 66.0];
/// Number of harmonics considered: transformers and rectifiers make even and odd ones.
const HARMONICS: usize = 8;
/// A harmonic is compared with the spectrum within this distance, Hz.
const NEAR_HZ: f64 = 6.0;
/// Half of a window in which a line's size and phase change linearly, s: longer than a cycle, shorter than a swell.
const HALF_WINDOW_S: f64 = 0.25;

/// A displacement without the hum seen at rest.
pub fn without_hum(x: &[f64], recording: &Recording) -> Vec<f64> {
    let lines = lines_at_rest(x, recording);
    if lines.is_empty() {
        return x.to_vec();
    }
    without(x, recording.interval_s(), &lines)
}

/// The mains line and its harmonics in the longest rest, Hz.
pub fn lines_at_rest(x: &[f64], recording: &Recording) -> Vec<f64> {
    let h = recording.interval_s();
    let at_rest = crate::record::rest::spans(recording);
    let Some(&(first, end)) = at_rest.iter().max_by_key(|(a, b)| b - a) else {
        return Vec::new();
    };
    let still = without_trend(&x[first..end]);
    let line = line_hz(&still, h, MAINS_HZ[0], MAINS_HZ[1]);
    let Some((at_rest_hz, _)) = line.filter(|(_, prominence)| *prominence >= PROMINENT) else {
        return Vec::new();
    };
    let bin_hz = 1.0 / (still.len() as f64 * h);
    let near = |found: f64, hz: f64| (found - hz).abs() <= 1.5 * bin_hz;
    // The whole record gives the frequency more precisely, unless the motion drowns it.
    let whole = line_hz(x, h, MAINS_HZ[0], MAINS_HZ[1]).filter(|(hz, _)| near(*hz, at_rest_hz));
    let hz = whole.map_or_else(
        || between_bins(&still, h, at_rest_hz),
        |(hz, _)| between_bins(x, h, hz),
    );
    let harmonics = (1..=HARMONICS).map(|n| n as f64 * hz);
    let below = harmonics.filter(|hz| hz * h < 0.45);
    below.filter(|hz| stands(&still, h, *hz)).collect()
}

/// True if a line of known frequency stands out from its neighbourhood, which is taken at whole bins' distance, where
/// the line itself contributes nothing.
fn stands(still: &[f64], interval_s: f64, line_hz: f64) -> bool {
    let power = |hz: f64| {
        let (c, s) = quadratures(still, interval_s, hz);
        c * c + s * s
    };
    let bin_hz = 1.0 / (still.len() as f64 * interval_s);
    let bins = (NEAR_HZ / bin_hz) as i32;
    let mut near: Vec<f64> = (-bins..=bins)
        .map(|k| line_hz + f64::from(k) * bin_hz)
        .filter(|hz| *hz > 0.0 && hz * interval_s < 0.5)
        .map(power)
        .collect();
    near.sort_by(f64::total_cmp);
    near.get(near.len() / 2)
        .is_some_and(|median| power(line_hz) >= PROMINENT * median)
}

/// Removes lines whose sizes and phases change slowly, fitted per window, with half-overlapping Hann windows that add
/// up to one.
fn without(x: &[f64], interval_s: f64, lines_hz: &[f64]) -> Vec<f64> {
    let half = (HALF_WINDOW_S / interval_s).round() as usize;
    let mut clean = x.to_vec();
    for centre in (0..x.len() + half).step_by(half) {
        let (from, end) = (centre.saturating_sub(half), (centre + half).min(x.len()));
        let place = |i: usize| (i as f64 - centre as f64) / half as f64;
        let weight = |i: usize| (0.25 * TAU * place(i)).cos();
        let waves = lines_hz.iter().flat_map(|hz| {
            [0.0, 0.25]
                .map(|phase| move |i: usize| (TAU * (hz * i as f64 * interval_s + phase)).sin())
        });
        let line: Vec<Vec<f64>> = waves
            .flat_map(|wave| {
                let steady = (from..end).map(|i| weight(i) * wave(i));
                let growing = (from..end).map(|i| weight(i) * place(i) * wave(i));
                [steady.collect(), growing.collect()]
            })
            .collect();
        // Within a window the motion beneath them is a straight line.
        let mut all = line.clone();
        all.push((from..end).map(weight).collect());
        all.push((from..end).map(|i| weight(i) * place(i)).collect());
        let part: Vec<f64> = (from..end).map(|i| weight(i) * x[i]).collect();
        let right = DVector::from_fn(all.len(), |i, _| dot(&all[i], &part));
        let Some(factor) = gram(&all).cholesky() else {
            continue;
        };
        let sizes = factor.solve(&right);
        for (column, size) in line.iter().zip(sizes.iter()) {
            for (i, wave) in (from..end).zip(column) {
                clean[i] -= size * weight(i) * wave;
            }
        }
    }
    clean
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numbers::signals::rms;

    #[test]
    fn a_harmonic_is_found_in_a_short_rest_and_none_is_where_there_is_none() {
        let (h, n) = (1e-3, 1550);
        let record = |third: f64, seed: usize| {
            let noise =
                |i: usize| 9e-3 * (((i * 7919 + seed * 104_729) % 1009) as f64 / 504.5 - 1.0);
            let wave = |i: usize, k: f64| (TAU * 59.9 * k * i as f64 * h + k).sin();
            let still = (0..n).map(|i| 0.25 * wave(i, 1.0) + third * wave(i, 3.0) + noise(i));
            let moves = (0..6000).map(|i| (TAU * 0.7e-3 * i as f64).sin() * 20.0);
            let x: Vec<f64> = still.chain(moves).collect();
            Recording {
                time_s: (0..x.len()).map(|i| i as f64 * h).collect(),
                command_mm: Some(
                    (0..x.len())
                        .map(|i| if i < n { 0.0 } else { x[i] })
                        .collect(),
                ),
                displacement_mm: Some(x),
                ..Recording::default()
            }
        };
        for seed in 0..20 {
            let found = |third: f64| {
                let record = record(third, seed);
                lines_at_rest(record.displacement_mm.as_ref().unwrap(), &record)
            };
            let [alone, both] = [0.0, 0.08].map(found);
            assert_eq!(alone.len(), 1, "{alone:?}");
            assert_eq!(both.len(), 2, "{both:?}");
            assert!((both[1] - 179.7).abs() < 0.65, "{both:?}");
        }
    }

    #[test]
    fn a_hum_that_swells_is_taken_off_and_the_motion_stays() {
        let (h, n) = (1e-3, 12_000);
        let motion = |t: f64| {
            let into = ((t - 2.0) / 8.0).clamp(0.0, 1.0);
            10.0 * (0.5 * TAU * into).sin().powi(2) * (TAU * 0.9 * t * t).sin()
        };
        let hum = |t: f64| {
            let swell = 1.0 + 0.1 * (TAU * 0.4 * t).sin();
            let wave = |n: f64| (TAU * 50.17 * n * t + n).sin();
            0.3 * swell * (wave(1.0) + 0.2 * wave(2.0) + 0.35 * wave(3.0) + 0.12 * wave(5.0))
        };
        let noise = |i: usize| 2e-3 * (((i * 7919) % 1009) as f64 / 504.5 - 1.0);
        let times: Vec<f64> = (0..n).map(|i| i as f64 * h).collect();
        let read: Vec<f64> = (0..n)
            .map(|i| motion(times[i]) + hum(times[i]) + noise(i))
            .collect();
        let record = Recording {
            command_mm: Some(times.iter().map(|t| motion(*t)).collect()),
            displacement_mm: Some(read.clone()),
            time_s: times.clone(),
            ..Recording::default()
        };
        let clean = without_hum(&read, &record);
        let left: Vec<f64> = clean
            .iter()
            .zip(&times)
            .enumerate()
            .map(|(i, (x, t))| x - motion(*t) - noise(i))
            .collect();
        let left = rms(&[left]);
        // Of 0.23 mm.
        assert!(left < 3e-3, "{left} mm");
    }
}
