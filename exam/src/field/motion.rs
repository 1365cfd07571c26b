//! What a laboratory without our advice moves its rigs by.

use crate::dice::Dice;
use crate::fine::{DT, FINE_HZ, lag, peak};
use std::f64::consts::TAU;

/// The wave form.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Move {
    /// Some sines.
    Multisine,
    /// A sweep.
    Chirp,
    /// Noise below a frequency.
    Random,
    /// Cycles whose amplitude grows in steps, as for a specimen that degrades.
    Growing,
    /// Ramps between random places, with pauses.
    RampAndHold,
    /// A sweep that stays on one side of zero.
    OneSided,
    /// One frequency, one amplitude.
    OneFrequency,
    /// Back and forth at one speed.
    OneSpeed,
}

impl Move {
    /// One that a specimen is moved by.
    pub(super) fn of_specimens(breadth: bool, dice: &mut Dice) -> Self {
        let broad = [
            Self::Multisine,
            Self::Chirp,
            Self::Random,
            Self::Growing,
            Self::RampAndHold,
        ];
        let narrow = [Self::OneFrequency, Self::OneSpeed, Self::OneSided];
        if breadth || dice.chance(0.6) {
            dice.pick(&broad)
        } else {
            dice.pick(&narrow)
        }
    }

    /// One that an actuator is moved by.
    pub(super) fn of_actuators(dice: &mut Dice) -> Self {
        let usual = [Self::Multisine, Self::Chirp, Self::Random];
        let odd = [Self::OneFrequency, Self::OneSpeed, Self::RampAndHold];
        if dice.chance(0.7) {
            dice.pick(&usual)
        } else {
            dice.pick(&odd)
        }
    }
}

/// A motion on the fine grid, and how much of its beginning is not recorded.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    pub(super) x: Vec<f64>,
    pub(super) from: usize,
    pub(super) end: usize,
    pub(super) rate_hz: f64,
}

/// Wave form, size and times of a test.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    pub(super) kind: Move,
    pub(super) amplitude_mm: f64,
    /// Where its motion ends, Hz.
    pub(super) high_hz: f64,
    rate_hz: f64,
    seconds: f64,
    /// With a rest before it, or else in mid-motion.
    rests: bool,
}

/// What a rig did before the record begins, s.
const BEFORE_S: f64 = 5.0;
/// A rest, s.
const REST_S: f64 = 1.5;

impl Plan {
    pub(super) fn draw(kind: Move, dice: &mut Dice) -> Self {
        let high_hz = dice.log_between(0.5, 4.0);
        let rate_hz: f64 = dice.pick(&[100.0, 200.0, 250.0, 500.0, 1000.0]);
        // A few thousand samples and at least a dozen cycles.
        let seconds = (3000.0 / rate_hz).max(14.0 / high_hz).clamp(8.0, 30.0);
        Self {
            kind,
            amplitude_mm: dice.log_between(2.0, 50.0),
            high_hz,
            rate_hz,
            seconds,
            rests: dice.chance(0.3),
        }
    }

    /// Largest speed to be expected, mm/s.
    pub(super) fn speed(&self) -> f64 {
        let x = self.trajectory(self.seconds, &mut Dice::new(7));
        let steps: Vec<f64> = x.windows(2).map(|w| (w[1] - w[0]) / DT).collect();
        peak(&steps[(0.2 * FINE_HZ) as usize..])
    }

    /// To learn from and to be judged on: two parts of one record, or two records, the second no larger.
    pub(super) fn pair(&self, one_file: bool, dice: &mut Dice) -> [Moved; 2] {
        let n = |seconds: f64| (seconds * FINE_HZ) as usize;
        let moved = |x, from, end| Moved {
            x,
            from,
            end,
            rate_hz: self.rate_hz,
        };
        let lead = if self.rests { REST_S } else { BEFORE_S };
        let from = if self.rests { 0 } else { n(lead) };
        if one_file {
            let x = self.whole(lead, 2.0 * self.seconds, dice);
            let middle = n(lead + 1.2 * self.seconds);
            let end = n(lead + 2.0 * self.seconds);
            return [moved(x.clone(), from, middle), moved(x, middle, end)];
        }
        [1.0, 0.6].map(|share| {
            let x = self.whole(lead, share * self.seconds, dice);
            moved(x, from, n(lead + share * self.seconds))
        })
    }

    fn whole(&self, lead: f64, seconds: f64, dice: &mut Dice) -> Vec<f64> {
        let mut x = self.trajectory(lead + seconds + 0.1, dice);
        if self.rests {
            let grows = |i: usize| ((i as f64 * DT - lead) / 0.5).clamp(0.0, 1.0);
            let still = x[(lead * FINE_HZ) as usize] * f64::from(self.kind == Move::OneSided);
            for (i, x) in x.iter_mut().enumerate() {
                let g = grows(i);
                *x = still + g * g * (3.0 - 2.0 * g) * (*x - still);
            }
        }
        x
    }

    fn trajectory(&self, seconds: f64, dice: &mut Dice) -> Vec<f64> {
        let n = (seconds * FINE_HZ) as usize;
        let t = |i: usize| i as f64 * DT;
        let (a, hz) = (self.amplitude_mm, self.high_hz);
        let start = dice.between(0.0, TAU);
        let sweep = |i: usize, from: f64| {
            (start + TAU * (from * t(i) + 0.5 * (hz - from) * t(i).powi(2) / seconds)).sin()
        };
        match self.kind {
            Move::Multisine => {
                let lines: Vec<[f64; 3]> = (1..=12)
                    .map(|i| {
                        let f = hz * (f64::from(i) + dice.between(-0.3, 0.3)) / 12.0;
                        [f, dice.between(0.5, 1.0), dice.between(0.0, TAU)]
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
                let white: Vec<f64> = (0..n).map(|_| dice.normal()).collect();
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
                let (mut at, mut goal, mut wait) = (0.0, a * dice.between(-1.0, 1.0), 0.0);
                let speed = 2.0 * a * hz;
                let mut speed_now = speed * dice.log_between(0.2, 1.0);
                let walk = (0..n)
                    .map(|_| {
                        let left: f64 = goal - at;
                        if left.abs() > speed_now * DT {
                            at += speed_now * DT * left.signum();
                        } else if wait <= 0.0 {
                            wait = dice.between(0.1, 0.6) / hz;
                            at = goal;
                        } else {
                            wait -= DT;
                            if wait <= 0.0 {
                                goal = a * dice.between(-1.0, 1.0);
                                speed_now = speed * dice.log_between(0.2, 1.0);
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
                // An actuator rounds the corners off.
                lag(&(0..n).map(triangle).collect::<Vec<_>>(), 0.004 / hz)
            }
        }
    }
}

fn sized(x: Vec<f64>, amplitude: f64) -> Vec<f64> {
    let by = amplitude / peak(&x).max(f64::MIN_POSITIVE);
    x.into_iter().map(|x| by * x).collect()
}
