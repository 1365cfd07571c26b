//! Where nothing moves.

use crate::recording::{Recording, range};

/// The shortest rest that tells the noise, s.
const SHORTEST_S: f64 = 0.5;
/// What a rig rings on for after its command has come to rest, s.
const SETTLING_S: f64 = 0.5;

/// Samples `first..end` of rest before and after the motion of a record.
pub fn spans(recording: &Recording) -> Vec<(usize, usize)> {
    let Some(activity) = recording
        .command_mm
        .as_ref()
        .or(recording.displacement_mm.as_ref())
    else {
        return Vec::new();
    };
    let h = recording.interval_s();
    let n = activity.len();
    let least = (SHORTEST_S / h).ceil() as usize;
    let before = still(activity.iter(), n, h);
    let after = still(activity.iter().rev(), n, h).saturating_sub((SETTLING_S / h) as usize);
    let mut spans = Vec::new();
    if before >= least {
        spans.push((0, before));
    }
    if after >= least && before + after < n {
        spans.push((n - after, n));
    }
    spans
}

/// How many samples from one end on stand still.
fn still<'a>(samples: impl Iterator<Item = &'a f64>, n: usize, interval_s: f64) -> usize {
    let x: Vec<f64> = samples.copied().collect();
    let head = ((0.25 / interval_s) as usize).clamp(8, n);
    let mut sorted = x[..head].to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[head / 2];
    let rms = (x[..head].iter().map(|x| (x - median).powi(2)).sum::<f64>() / head as f64).sqrt();
    let whole = range(&x);
    if rms > 0.02 * whole {
        return 0;
    }
    let room = (6.0 * rms).max(1e-3 * whole);
    let moved = x
        .iter()
        .position(|x| (x - median).abs() > room)
        .unwrap_or(n);
    // The last moments may be the start of the motion, still inside the room.
    moved.saturating_sub((0.1 / interval_s) as usize)
}

/// Period of a signal that repeats itself at least three times, samples.
pub fn period(x: &[f64]) -> Option<usize> {
    let n = x.len();
    let mean = x.iter().sum::<f64>() / n as f64;
    let x: Vec<f64> = x.iter().map(|x| x - mean).collect();
    let crossings: Vec<usize> = (1..n).filter(|&i| x[i - 1] < 0.0 && x[i] >= 0.0).collect();
    if crossings.len() < 4 {
        return None;
    }
    let span = crossings[crossings.len() - 1] - crossings[0];
    let guess = span as f64 / (crossings.len() - 1) as f64;
    (guess as usize..=guess.ceil() as usize)
        .filter(|&p| p > 8 && 3 * p < n)
        .find(|&p| crate::recording::correlation(&x[p..], &x[..n - p]) > 0.99)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rest_lies_before_and_after_the_motion() {
        let h = 1e-3;
        let command = |i: usize| {
            let t = i as f64 * h;
            if (2.0..8.0).contains(&t) {
                ((t - 2.0) * 6.0).sin()
            } else {
                1e-4 * ((i * 7919) % 11) as f64
            }
        };
        let r = Recording {
            time_s: (0..10_000).map(|i| i as f64 * h).collect(),
            command_mm: Some((0..10_000).map(command).collect()),
            ..Recording::default()
        };
        let found = spans(&r);
        assert_eq!(found.len(), 2);
        assert!(
            found[0].0 == 0 && (1850..=2005).contains(&found[0].1),
            "{found:?}"
        );
        assert!(
            (8400..=8700).contains(&found[1].0) && found[1].1 == 10_000,
            "{found:?}"
        );
    }

    #[test]
    fn a_period_is_found_where_there_is_one() {
        let sine: Vec<f64> = (0..4000)
            .map(|i| (i as f64 * std::f64::consts::TAU / 250.0).sin())
            .collect();
        assert!((249..=251).contains(&period(&sine).unwrap()));
        let sweep: Vec<f64> = (0..4000).map(|i| (1e-5 * (i * i) as f64).sin()).collect();
        assert_eq!(period(&sweep), None);
    }
}
