//! Detects where nothing moves.

use crate::numbers::signals::deviation;
use crate::record::recording::{Recording, range};

/// Shortest rest that determines the noise, s.
const SHORTEST_S: f64 = 0.5;
/// Time for which a rig keeps ringing after its command has come to rest, s.
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
    let whole = range(activity);
    let mut spans = Vec::new();
    if before >= least {
        spans.push((0, before));
    }
    if after >= least && before + after < n {
        spans.push((n - after, n));
    }
    spans.retain(|&(a, b)| !swings(&activity[a..b], whole));
    // What moves more than the other rest is not at rest: a motion that begins slowly is cut off,
    // but no more than half.
    let moves = |&(a, b): &(usize, usize)| deviation(&activity[a..b]);
    let quietest = spans.iter().map(moves).fold(f64::MAX, f64::min);
    let most = 3.0 * quietest.max(1e-5 * whole);
    for span in &mut spans {
        let half = (span.1 - span.0) / 2;
        while span.1 - span.0 > half && moves(span) > most {
            let cut = (span.1 - span.0).div_ceil(10);
            if span.0 == 0 {
                span.1 -= cut;
            } else {
                span.0 += cut;
            }
        }
    }
    spans.retain(|span| span.1 - span.0 >= least && moves(span) <= most);
    spans
}

/// The record without the rests before and after its motion, which stay available as its past. In a rest, friction that
/// sticks holds the forces left by the last motions, even those smaller than the displacement's noise: a rest shows
/// noise and offset, but no law of a force with memory.
pub fn without(recording: &Recording) -> Recording {
    let part = moving(recording);
    if part.len() == recording.time_s.len() {
        return recording.clone();
    }
    recording.slice(part.start, part.end)
}

/// Samples between the rests.
pub fn moving(recording: &Recording) -> std::ops::Range<usize> {
    let n = recording.time_s.len();
    let (mut first, mut end) = (0, n);
    for (a, b) in spans(recording) {
        if a == 0 {
            first = b;
        } else {
            end = a;
        }
    }
    if end.saturating_sub(first) < n / LEAST_MOTION {
        return 0..n;
    }
    first..end
}

/// The motion takes at least one in this many of a record's samples.
const LEAST_MOTION: usize = 8;

/// True if a small movement is smooth: a structure that still rings, not the noise of one at rest.
fn swings(x: &[f64], whole: f64) -> bool {
    let rms = deviation(x);
    let n = x.len() as f64;
    let step = (x.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>() / n).sqrt();
    rms > 2e-3 * whole && step < 0.1 * rms
}

/// Number of constant samples from one end on.
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
    // The last moments may be the start of the motion, still within the tolerance.
    moved.saturating_sub((0.1 / interval_s) as usize)
}

/// A periodic motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Periodic {
    /// Period, samples.
    pub period: usize,
    /// First sample of the part in which each period is like the one before.
    pub from: usize,
    /// Its end.
    pub end: usize,
}

/// Largest rms difference between successive periods of a motion, relative to its own rms.
const LIKE: f64 = 0.05;

/// The longest part of a signal that repeats at least three times.
pub fn periodic(x: &[f64]) -> Option<Periodic> {
    let n = x.len();
    let mean = x.iter().sum::<f64>() / n as f64;
    let x: Vec<f64> = x.iter().map(|x| x - mean).collect();
    let rms = (x.iter().map(|x| x * x).sum::<f64>() / n as f64).sqrt();
    // Upward crossings, and only after it was well below: noise crosses back and forth.
    let below = -0.2 * range(&x);
    let (mut ready, mut crossings) = (false, Vec::new());
    for i in 1..n {
        ready |= x[i] < below;
        if ready && x[i - 1] < 0.0 && x[i] >= 0.0 {
            crossings.push(i);
            ready = false;
        }
    }
    if crossings.len() < 4 {
        return None;
    }
    let mut gaps: Vec<usize> = crossings.windows(2).map(|c| c[1] - c[0]).collect();
    gaps.sort_unstable();
    let middle = gaps[gaps.len() / 2];
    let candidates = middle.saturating_sub(2).max(8)..=middle + 2;
    candidates
        .filter_map(|period| steady(&x, period, LIKE * rms))
        .max_by_key(|found| found.end - found.from)
}

/// The longest run of whole periods that are each like the one before.
fn steady(x: &[f64], period: usize, room: f64) -> Option<Periodic> {
    let differs = |from: usize| {
        let square = |i: usize| (x[i] - x[i - period]).powi(2);
        let sum: f64 = (from..from + period).map(square).sum();
        (sum / period as f64).sqrt() > room
    };
    let (mut best, mut from) = (0..0, period);
    let mut at = period;
    while at + period <= x.len() {
        if differs(at) {
            from = at + period;
        } else if at + period - from > best.len() {
            best = from..at + period;
        }
        at += period;
    }
    (best.len() >= 2 * period).then_some(Periodic {
        period,
        from: best.start,
        end: best.end,
    })
}

/// Number of parts of a period by which differences are judged.
const PARTS: usize = 12;
/// A part whose mean square exceeds this multiple of the median is not noise: the motion did not repeat exactly there,
/// which a force that jumps reveals.
const LOUD: f64 = 4.0;

/// The segments of differences between periods that are as quiet as most.
pub fn quiet(changes: &[f64], period: usize) -> Vec<Vec<f64>> {
    let length = (period / PARTS).max(16).min(changes.len().max(1));
    let square = |c: &[f64]| c.iter().map(|x| x * x).sum::<f64>() / c.len() as f64;
    let parts: Vec<&[f64]> = changes.chunks_exact(length).collect();
    let mut sorted: Vec<f64> = parts.iter().map(|c| square(c)).collect();
    sorted.sort_by(f64::total_cmp);
    let Some(median) = sorted.get(sorted.len() / 2).copied() else {
        return vec![changes.to_vec()];
    };
    let mut segments: Vec<Vec<f64>> = Vec::new();
    let mut open = false;
    for part in parts {
        let is_quiet = square(part) <= LOUD * median;
        match segments.last_mut().filter(|_| open && is_quiet) {
            Some(last) => last.extend_from_slice(part),
            None if is_quiet => segments.push(part.to_vec()),
            None => {}
        }
        open = is_quiet;
    }
    segments
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
        // A structure that still rings is not at rest, however little it moves.
        let mut rings = r;
        for (i, u) in rings.command_mm.iter_mut().flatten().enumerate() {
            let late = (i as f64 * h - 8.0).max(0.0);
            *u += if late > 0.0 {
                0.01 * (12.0 * late).sin()
            } else {
                0.0
            };
        }
        assert_eq!(spans(&rings), found[..1]);
        // A motion that begins slowly leaves the rest before it.
        let slow = |i: usize| {
            let t = i as f64 * h;
            let grows = ((t - 2.0).max(0.0) / 4.0).powi(4);
            if t < 8.0 {
                grows * (6.0 * t).sin()
            } else {
                0.0
            }
        };
        let slow = Recording {
            command_mm: Some((0..10_000).map(slow).collect()),
            ..rings
        };
        let found = spans(&slow);
        assert_eq!(found.len(), 2);
        assert!((1500..2700).contains(&found[0].1), "{found:?}");
    }

    #[test]
    fn a_period_is_found_where_there_is_one() {
        let sine: Vec<f64> = (0..4000)
            .map(|i| (i as f64 * std::f64::consts::TAU / 250.0).sin())
            .collect();
        let found = periodic(&sine).unwrap();
        assert_eq!((found.period, found.from, found.end), (250, 250, 4000));
        // A start that grows is not part of it.
        let grows = |i: usize| (i as f64 / 1000.0).min(1.0);
        let soft: Vec<f64> = sine.iter().enumerate().map(|(i, x)| x * grows(i)).collect();
        let found = periodic(&soft).unwrap();
        assert!(found.period == 250 && found.from >= 1000, "{found:?}");
        let sweep: Vec<f64> = (0..4000).map(|i| (1e-5 * (i * i) as f64).sin()).collect();
        assert_eq!(periodic(&sweep), None);
    }
}
