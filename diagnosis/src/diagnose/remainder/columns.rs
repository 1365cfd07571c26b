//! What a rest may depend on: columns for each class, of no equation in particular.

use crate::model::answer::{DependsOn, Range};
use crate::numbers::operators::slider;
use crate::numbers::signals::{derivative, lagged};

/// The motion of one record beside its rest.
#[derive(Clone, Debug)]
pub struct Moves {
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Time of the first sample by the record's own stamps, s.
    pub begin_s: f64,
    /// What goes into the channel, without its noise, mm.
    pub x: Vec<f64>,
    /// Its speed, mm/s.
    pub v: Vec<f64>,
    /// Another signal of the record: the force beside an actuator, the command beside a specimen; empty without one.
    pub other: Vec<f64>,
    /// What the model leaves.
    pub rest: Vec<f64>,
}

impl Moves {
    /// From an input; its noise above the band of the motion is taken off.
    pub fn new(input: &[f64], other: Vec<f64>, rest: Vec<f64>, interval_s: f64) -> Self {
        let band = crate::record::spectrum::motion_band_hz(input, interval_s);
        let x = match band {
            Some(hz) => {
                crate::record::spectrum::smooth(input, interval_s, (4.0 * hz).min(0.3 / interval_s))
                    .x
            }
            None => input.to_vec(),
        };
        Self {
            interval_s,
            begin_s: 0.0,
            v: derivative(&x, interval_s),
            x,
            other,
            rest,
        }
    }
}

impl Range {
    /// Of records.
    pub fn of(records: &[Moves]) -> Self {
        let ends = |of: fn(&Moves) -> &Vec<f64>| {
            let all = records.iter().flat_map(of);
            all.fold([f64::MAX, f64::MIN], |[l, h], x| [l.min(*x), h.max(*x)])
        };
        let seconds = records.iter().map(|m| m.x.len() as f64 * m.interval_s);
        Self {
            x_mm: ends(|m| &m.x),
            v_mm_per_s: ends(|m| &m.v),
            other: ends(|m| &m.other),
            seconds: seconds.fold(f64::MAX, f64::min),
        }
    }
}

/// Hats over a range, and over each of two ranges.
const HATS: usize = 9;
const HATS_OF_TWO: usize = 6;
/// Sliders of a memory, by the half range.
const SLIDERS: [f64; 10] = [0.004, 0.01, 0.02, 0.04, 0.08, 0.15, 0.25, 0.4, 0.6, 0.9];
/// Filters, from a few samples to this share of a record.
const FILTERS: usize = 8;
const SLOWEST: f64 = 0.05;
/// Steps of amplitude.
const AMPLITUDES: usize = 4;

/// Shares of hats at a value of a range, in the hats' order: a straight line between the two nearest; nothing outside.
fn hats(value: f64, [low, high]: [f64; 2], n: usize) -> impl Iterator<Item = f64> {
    let at = (value - low) / (high - low).max(f64::MIN_POSITIVE) * (n - 1) as f64;
    let inside = (-1e-9..=(n - 1) as f64 + 1e-9).contains(&at);
    (0..n).map(move |i| {
        if inside {
            (1.0 - (at - i as f64).abs()).max(0.0)
        } else {
            0.0
        }
    })
}

/// Columns of a class for one record, the same number for every record.
pub fn columns(class: DependsOn, m: &Moves, range: &Range) -> Vec<Vec<f64>> {
    let n = m.x.len();
    let h = m.interval_s;
    let by_hats = |signal: &[f64], ends: [f64; 2]| {
        let mut all = vec![vec![0.0; n]; HATS];
        for (i, s) in signal.iter().enumerate() {
            for (column, share) in all.iter_mut().zip(hats(*s, ends, HATS)) {
                column[i] = share;
            }
        }
        all
    };
    match class {
        DependsOn::Displacement => by_hats(&m.x, range.x_mm),
        DependsOn::Velocity => by_hats(&m.v, range.v_mm_per_s),
        DependsOn::OtherChannel if m.other.is_empty() => Vec::new(),
        DependsOn::OtherChannel => by_hats(&m.other, range.other),
        DependsOn::DisplacementAndVelocity => {
            let mut all = vec![vec![0.0; n]; HATS_OF_TWO * HATS_OF_TWO];
            for i in 0..n {
                let in_v: Vec<f64> = hats(m.v[i], range.v_mm_per_s, HATS_OF_TWO).collect();
                for (a, share) in hats(m.x[i], range.x_mm, HATS_OF_TWO).enumerate() {
                    for (b, other) in in_v.iter().enumerate() {
                        all[a * HATS_OF_TWO + b][i] = share * other;
                    }
                }
            }
            all
        }
        DependsOn::Memory => {
            let half = 0.5 * (range.x_mm[1] - range.x_mm[0]);
            SLIDERS.iter().map(|d| slider(&m.x, d * half)).collect()
        }
        DependsOn::Frequency => {
            let slowest = SLOWEST * range.seconds;
            let ratio = slowest / (2.0 * h);
            let tau = |i: usize| 2.0 * h * ratio.powf(i as f64 / (FILTERS - 1) as f64);
            (0..FILTERS)
                .map(|i| lagged(&m.x, tau(i), h))
                .chain([m.x.clone(), m.v.clone()])
                .collect()
        }
        DependsOn::Amplitude => {
            let size = envelope(&m.x, h, range.seconds);
            let half = 0.5 * (range.x_mm[1] - range.x_mm[0]);
            let mut all = vec![vec![0.0; n]; 2 * AMPLITUDES];
            for i in 0..n {
                for (k, share) in hats(size[i], [0.0, half], AMPLITUDES).enumerate() {
                    all[k][i] = share * m.x[i];
                    all[AMPLITUDES + k][i] = share * m.v[i];
                }
            }
            all
        }
        DependsOn::Time => {
            let samples: Vec<f64> = (0..n).map(|i| i as f64).collect();
            by_hats(&samples, [0.0, (n - 1) as f64])
        }
    }
}

/// The larger half range of the last moments, up to a tenth of a record.
fn envelope(x: &[f64], h: f64, seconds: f64) -> Vec<f64> {
    let decay = (-h / (0.02 * seconds)).exp();
    let (mut high, mut low) = (x[0], x[0]);
    x.iter()
        .map(|&x| {
            let middle = 0.5 * (high + low);
            high = x.max(middle + decay * (high - middle));
            low = x.min(middle + decay * (low - middle));
            0.5 * (high - low)
        })
        .collect()
}

/// The odd part of the strengths of a class: what changes its sign with the motion.
pub fn odd_part(class: DependsOn, weights: &[f64]) -> Vec<f64> {
    match class {
        // The mirror image of a hat, in one direction or in both, is the one as far from the other end.
        DependsOn::Displacement | DependsOn::Velocity | DependsOn::DisplacementAndVelocity => {
            weights
                .iter()
                .zip(weights.iter().rev())
                .map(|(w, mirrored)| 0.5 * (w - mirrored))
                .collect()
        }
        DependsOn::Memory | DependsOn::Frequency | DependsOn::Amplitude => weights.to_vec(),
        DependsOn::Time | DependsOn::OtherChannel => vec![0.0; weights.len()],
    }
}
