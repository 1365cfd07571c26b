//! How a laboratory that has not had our advice moves its rigs.

use crate::draws::Draws;
use crate::fine::{DT, FINE_HZ, lag, peak};
use crate::record::Record;
use std::f64::consts::TAU;

/// The waveform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Move {
    /// A sum of sines.
    Multisine,
    /// A sweep.
    Chirp,
    /// Noise below a frequency.
    Random,
    /// Cycles whose amplitude grows in steps, as for a specimen that degrades.
    Growing,
    /// Ramps between random positions, with pauses.
    RampAndHold,
    /// A sweep that stays on one side of zero.
    OneSided,
    /// One frequency, one amplitude.
    OneFrequency,
    /// Back and forth at a constant speed.
    OneSpeed,
}

impl Move {
    /// A waveform for a specimen.
    pub(super) fn of_specimens(breadth: bool, rng: &mut Draws) -> Self {
        let broad = [
            Self::Multisine,
            Self::Chirp,
            Self::Random,
            Self::Growing,
            Self::RampAndHold,
        ];
        let narrow = [Self::OneFrequency, Self::OneSpeed, Self::OneSided];
        if breadth || rng.chance(0.6) {
            rng.pick(&broad)
        } else {
            rng.pick(&narrow)
        }
    }

    /// A waveform for an actuator.
    pub(super) fn of_actuators(rng: &mut Draws) -> Self {
        let usual = [Self::Multisine, Self::Chirp, Self::Random];
        let odd = [Self::OneFrequency, Self::OneSpeed, Self::RampAndHold];
        if rng.chance(0.7) {
            rng.pick(&usual)
        } else {
            rng.pick(&odd)
        }
    }
}

/// A part of a record, and what its file contains before it.
#[derive(Clone, Debug)]
pub struct Span {
    /// The part that is given.
    pub record: Record,
    /// What was recorded before it, without a gap.
    pub before: Option<Record>,
}

/// A motion on the fine grid, and the steps from which and up to which it is recorded.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    pub(super) x: Vec<f64>,
    pub(super) from: usize,
    pub(super) end: usize,
    pub(super) rate_hz: f64,
}

/// Waveform, size and times of a test.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) kind: Move,
    pub(super) amplitude_mm: f64,
    /// Upper end of the motion's band, Hz.
    pub(super) high_hz: f64,
    pub(super) rate_hz: f64,
    /// Length of the first of two records, s; a single record is twice as long.
    seconds: f64,
    /// The rest before the motion, s; `None` if the record begins in mid-motion.
    rest_s: Option<f64>,
    spans: Spans,
}

/// How a laboratory divides its data into training and test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Spans {
    /// Two records, the second shorter.
    TwoFiles,
    /// The beginning of a record and what comes after it.
    Halves,
    /// Two pieces of one record, each cut out of mid-motion.
    Cut,
}

/// How long a rig moves before a record that begins in mid-motion, s.
const BEFORE_S: f64 = 5.0;
/// The usual rest, s.
const REST_S: f64 = 1.5;
/// Share of records that are short, with a short rest.
const SHORT: f64 = 0.2;

impl Plan {
    pub(super) fn draw(kind: Move, rng: &mut Draws) -> Self {
        let high_hz = rng.log_between(0.5, 4.0);
        let rate_hz: f64 = rng.pick(&[100.0, 200.0, 250.0, 500.0, 1000.0]);
        let amplitude_mm = rng.log_between(2.0, 50.0);
        let rests = rng.chance(0.3);
        if rng.chance(SHORT) {
            // Eight to twelve seconds in all.
            return Self {
                kind,
                amplitude_mm,
                high_hz: high_hz.max(2.0),
                rate_hz: rate_hz.max(250.0),
                seconds: rng.between(4.0, 6.0),
                rest_s: Some(rng.between(0.3, 0.5)),
                spans: Spans::Halves,
            };
        }
        // A few thousand samples and at least a dozen cycles.
        let seconds = (3000.0 / rate_hz).max(14.0 / high_hz).clamp(8.0, 30.0);
        Self {
            kind,
            amplitude_mm,
            high_hz,
            rate_hz,
            seconds,
            rest_s: rests.then_some(REST_S),
            spans: rng.pick(&[Spans::TwoFiles, Spans::Halves, Spans::Cut]),
        }
    }

    /// The plan for a laboratory's ram: two records with a rest.
    pub(super) fn of_rams(rng: &mut Draws) -> Self {
        let high_hz = rng.log_between(1.0, 4.0);
        Self {
            kind: rng.pick(&[Move::Multisine, Move::Chirp, Move::Random, Move::Growing]),
            amplitude_mm: rng.log_between(8.0, 40.0) / high_hz,
            high_hz,
            rate_hz: 500.0,
            seconds: 20.0,
            rest_s: Some(REST_S),
            spans: Spans::TwoFiles,
        }
    }

    /// The motion and how it is cut.
    pub(super) fn name(&self) -> String {
        let short = if self.seconds < 7.0 { "short " } else { "" };
        format!("{short}{:?} {:?}", self.kind, self.spans)
    }

    /// Whether it begins with a rest.
    pub(super) const fn rests(&self) -> bool {
        self.rest_s.is_some()
    }

    /// Largest expected speed, mm/s.
    pub(super) fn speed(&self) -> f64 {
        let x = self.trajectory(self.seconds, &mut Draws::new(7));
        let steps: Vec<f64> = x.windows(2).map(|w| (w[1] - w[0]) / DT).collect();
        peak(&steps[(0.2 * FINE_HZ) as usize..])
    }

    /// The recorded motions: one, or two of which the second is shorter.
    pub(super) fn motions(&self, rng: &mut Draws) -> Vec<Moved> {
        let n = |seconds: f64| (seconds * FINE_HZ) as usize;
        let lead = self.rest_s.unwrap_or(BEFORE_S);
        let shares: &[f64] = match self.spans {
            Spans::TwoFiles => &[1.0, 0.6],
            Spans::Halves | Spans::Cut => &[2.0],
        };
        let moved = |share: &f64| {
            let seconds = share * self.seconds;
            Moved {
                x: self.whole(lead, seconds, rng),
                from: if self.rest_s.is_some() { 0 } else { n(lead) },
                end: n(lead + seconds),
                rate_hz: self.rate_hz,
            }
        };
        shares.iter().map(moved).collect()
    }

    /// The training and the test part, each with what its file contains before it.
    pub(super) fn spans(&self, files: &[Record]) -> [Span; 2] {
        let whole = |r: &Record| Span {
            record: r.clone(),
            before: None,
        };
        let cut = |r: &Record, from: f64, to: f64| {
            let at = |share: f64| (share * r.time_s.len() as f64) as usize;
            Span {
                record: r.samples(at(from)..at(to)),
                before: (from > 0.0).then(|| r.samples(0..at(from))),
            }
        };
        match (self.spans, files) {
            (Spans::Halves, [one, ..]) => [cut(one, 0.0, 0.6), cut(one, 0.6, 1.0)],
            (Spans::Cut, [one, ..]) => [cut(one, 0.15, 0.6), cut(one, 0.65, 1.0)],
            (_, all) => [whole(&all[0]), whole(&all[all.len() - 1])],
        }
    }

    fn whole(&self, lead: f64, seconds: f64, rng: &mut Draws) -> Vec<f64> {
        let mut x = self.trajectory(lead + seconds + 0.1, rng);
        if self.rest_s.is_some() {
            let grows = |i: usize| ((i as f64 * DT - lead) / 0.5).clamp(0.0, 1.0);
            let still = x[(lead * FINE_HZ) as usize] * f64::from(self.kind == Move::OneSided);
            for (i, x) in x.iter_mut().enumerate() {
                let g = grows(i);
                *x = still + g * g * (3.0 - 2.0 * g) * (*x - still);
            }
        }
        x
    }

    fn trajectory(&self, seconds: f64, rng: &mut Draws) -> Vec<f64> {
        let n = (seconds * FINE_HZ) as usize;
        let t = |i: usize| i as f64 * DT;
        let (a, hz) = (self.amplitude_mm, self.high_hz);
        let start = rng.between(0.0, TAU);
        let sweep = |i: usize, from: f64| {
            (start + TAU * (from * t(i) + 0.5 * (hz - from) * t(i).powi(2) / seconds)).sin()
        };
        match self.kind {
            Move::Multisine => {
                let lines: Vec<[f64; 3]> = (1..=12)
                    .map(|i| {
                        let f = hz * (f64::from(i) + rng.between(-0.3, 0.3)) / 12.0;
                        [f, rng.between(0.5, 1.0), rng.between(0.0, TAU)]
                    })
                    .collect();
                let sum = |i| {
                    lines
                        .iter()
                        .map(|[f, s, p]| s * (TAU * f * t(i) + p).sin())
                        .sum()
                };
                sized((0..n).map(sum).collect(), a)
            }
            Move::Chirp => {
                let grows = |i| 1.0 - 0.5 * t(i) / seconds;
                (0..n).map(|i| a * grows(i) * sweep(i, 0.1 * hz)).collect()
            }
            Move::OneSided => (0..n)
                .map(|i| 0.5 * a * (1.2 + sweep(i, 0.2 * hz)))
                .collect(),
            Move::Random => {
                // The first value is zero because the filters start in equilibrium with it: from a random value, the
                // decaying start would be the largest part of the motion and set its scale.
                let white = (0..n).map(|i| if i == 0 { 0.0 } else { rng.normal() });
                let white: Vec<f64> = white.collect();
                let tau = 0.25 / (TAU * 0.25 * hz);
                let smooth = lag(&lag(&lag(&white, tau), tau), tau);
                let slow = lag(&smooth, 8.0 * tau);
                sized(smooth.iter().zip(&slow).map(|(x, s)| x - s).collect(), a)
            }
            Move::Growing => {
                let cycles = (0.5 * hz * seconds).max(6.0);
                let size =
                    |phase: f64| (0.15 + 0.85 * (phase / 2.0).floor() * 2.0 / cycles).min(1.0);
                let hz = 0.5 * hz;
                let wave = |i| {
                    let phase = hz * t(i);
                    a * size(phase) * (TAU * phase).sin()
                };
                lag(&(0..n).map(wave).collect::<Vec<_>>(), 0.02 / hz)
            }
            Move::RampAndHold => {
                let (mut at, mut goal, mut wait) = (0.0, a * rng.between(-1.0, 1.0), 0.0);
                let speed = 2.0 * a * hz;
                let mut speed_now = speed * rng.log_between(0.2, 1.0);
                let walk = (0..n)
                    .map(|_| {
                        let left: f64 = goal - at;
                        if left.abs() > speed_now * DT {
                            at += speed_now * DT * left.signum();
                        } else if wait <= 0.0 {
                            wait = rng.between(0.1, 0.6) / hz;
                            at = goal;
                        } else {
                            wait -= DT;
                            if wait <= 0.0 {
                                goal = a * rng.between(-1.0, 1.0);
                                speed_now = speed * rng.log_between(0.2, 1.0);
                            }
                        }
                        at
                    })
                    .collect::<Vec<f64>>();
                lag(&lag(&walk, 0.03 / hz), 0.03 / hz)
            }
            Move::OneFrequency => {
                let hz = 0.5 * hz;
                (0..n)
                    .map(|i| a * (start + TAU * hz * t(i)).sin())
                    .collect()
            }
            Move::OneSpeed => {
                let hz = 0.3 * hz;
                let triangle = |i| {
                    let phase = (start / TAU + hz * t(i)).fract();
                    a * (4.0 * (phase - 0.5).abs() - 1.0)
                };
                // An actuator rounds off the corners.
                lag(&(0..n).map(triangle).collect::<Vec<_>>(), 0.004 / hz)
            }
        }
    }
}

fn sized(x: Vec<f64>, amplitude: f64) -> Vec<f64> {
    let by = amplitude / peak(&x).max(f64::MIN_POSITIVE);
    x.into_iter().map(|x| by * x).collect()
}
