//! Possible dependences of a residual: columns for each class, independent of any particular equation.

use crate::model::answer::{DependsOn, Range};
use crate::numbers::operators::slider;
use crate::numbers::signals::{derivative, lagged};

/// The motion of a record, with its residual.
#[derive(Clone, Debug)]
pub struct Moves {
    /// Sampling interval, s.
    pub interval_s: f64,
    /// Time of the first sample by the record's own time stamps, s.
    pub begin_s: f64,
    /// The channel's input, without its noise, mm.
    pub x: Vec<f64>,
    /// Its speed, mm/s.
    pub v: Vec<f64>,
    /// Another signal of the record: the force for an actuator, the command for a specimen; empty if there is none.
    pub other: Vec<f64>,
    /// The model's residual.
    pub rest: Vec<f64>,
}

impl Moves {
    /// From an input; its noise above the motion's band is removed.
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
    /// From records.
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

/// Number of hats over one range, and over each of two ranges.
const HATS: usize = 9;
const HATS_OF_TWO: usize = 6;
/// Slider displacements for memory, relative to half the range.
const SLIDERS: [f64; 10] = [0.004, 0.01, 0.02, 0.04, 0.08, 0.15, 0.25, 0.4, 0.6, 0.9];
/// Number of filters, from a few samples to this fraction of a record.
const FILTERS: usize = 8;
const SLOWEST: f64 = 0.05;
/// Number of amplitude levels.
const AMPLITUDES: usize = 4;

/// Weights of hats at a value of a range, in the hats' order: linear between the two nearest; none outside.
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

/// Columns of a class for one record; every record has the same number.
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

/// Running maximum of the size, relative to the middle, over up to a tenth of a record.
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

/// The odd part of a class's strengths: it changes sign with the motion.
pub fn odd_part(class: DependsOn, weights: &[f64]) -> Vec<f64> {
    match class {
        // A hat's mirror image, in one direction or in both, is the one equally far from the other end.
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
