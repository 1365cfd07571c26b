//! Servo-hydraulic actuators (valve, oil column, cylinder and control) and their faults.

use super::mark::Truth;
use super::motion::{Move, Plan};
use crate::draws::Draws;
use crate::fine::{DT, delay};
use std::f64::consts::TAU;

/// The undeclared cause.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Drive {
    Nothing,
    Slower,
    Later,
    Gain,
    OilColumn,
    Overlap,
    UnequalAreas,
    FlowLimit,
    SealFriction,
    LinkPlay,
    Hunting,
    SecondAxis,
}

impl Drive {
    pub(super) const ALL: [Self; 12] = [
        Self::Nothing,
        Self::Slower,
        Self::Later,
        Self::Gain,
        Self::OilColumn,
        Self::Overlap,
        Self::UnequalAreas,
        Self::FlowLimit,
        Self::SealFriction,
        Self::LinkPlay,
        Self::Hunting,
        Self::SecondAxis,
    ];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Nothing => "actuator: nothing",
            Self::Slower => "slower than declared",
            Self::Later => "later than declared",
            Self::Gain => "another gain",
            Self::OilColumn => "soft oil column",
            Self::Overlap => "valve overlap",
            Self::UnequalAreas => "unequal areas",
            Self::FlowLimit => "flow limit",
            Self::SealFriction => "seal friction",
            Self::LinkPlay => "play in the linkage",
            Self::Hunting => "hunting valve",
            Self::SecondAxis => "actuator: a second axis",
        }
    }
}

/// An actuator: the valve's opening follows the error, the flow through it moves the oil, and the oil's spring moves the mass.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    cause: Drive,
    /// Delay and lag without the cause, ms.
    pub(super) declared_ms: [f64; 2],
    delay_s: f64,
    lag_s: f64,
    gain: f64,
    oil_hz: f64,
    damping: f64,
    amplitude_mm: f64,
    speed: f64,
    size: f64,
    shape: f64,
    lines: Vec<[f64; 2]>,
}

impl Rig {
    pub(super) fn draw(plan: &Plan, cause: Drive, rng: &mut Draws) -> Self {
        let (delay_s, lag_s) = (rng.between(2e-3, 10e-3), rng.between(12e-3, 35e-3));
        let size = rng.between(0.0, 1.0);
        let (mut later, mut slower) = (0.0, 1.0);
        if cause == Drive::Later {
            later = 4e-3 + 8e-3 * size;
        }
        if cause == Drive::Slower {
            slower = 1.4 + 0.6 * size;
        }
        let soft = cause == Drive::OilColumn;
        Self {
            cause,
            declared_ms: [1e3 * delay_s, 1e3 * lag_s],
            delay_s: delay_s + later,
            lag_s: lag_s * slower,
            gain: if cause == Drive::Gain {
                1.0 + rng.sign() * (0.05 + 0.1 * size)
            } else {
                1.0
            },
            // Near the loop's bandwidth if the column is soft, otherwise far above it.
            oil_hz: if soft {
                (2.0 + 2.0 * size) / (TAU * lag_s)
            } else {
                40.0 / (TAU * lag_s)
            },
            damping: if soft { rng.between(0.35, 0.7) } else { 0.8 },
            amplitude_mm: plan.amplitude_mm,
            speed: plan.speed(),
            size,
            shape: rng.between(0.0, 1.0),
            lines: (0..4)
                .map(|_| [rng.between(0.4, 3.0) * plan.high_hz, rng.between(0.0, TAU)])
                .collect(),
        }
    }

    pub(super) fn displacement(&self, command: &[f64], rng: &mut Draws) -> Vec<f64> {
        let late = delay(command, self.delay_s);
        let (big, top) = (self.amplitude_mm, self.speed);
        // The largest opening, mm: how far the displacement lags behind its command at top speed.
        let open = top * self.lag_s;
        let omega = TAU * self.oil_hz;
        let (mut ram, mut x, mut v) = (self.gain * late[0], self.gain * late[0], 0.0);
        let (mut phase, mut link) = (rng.between(0.0, TAU), x);
        let mut bristle = 0.0_f64;
        let starts: Vec<f64> = self.lines.iter().map(|_| rng.between(0.0, TAU)).collect();
        late.iter()
            .enumerate()
            .map(|(i, u)| {
                let t = i as f64 * DT;
                let mut e = self.gain * u - x;
                match self.cause {
                    Drive::Overlap => {
                        let lap = open * (0.05 + 0.25 * self.size);
                        e -= e.clamp(-lap, lap);
                    }
                    Drive::UnequalAreas => {
                        let ratio = 0.1 + 0.25 * self.size;
                        e *= if e > 0.0 { 1.0 + ratio } else { 1.0 - ratio };
                    }
                    Drive::FlowLimit => {
                        let most = open * (0.5 + 0.35 * self.size);
                        e = e.clamp(-most, most);
                    }
                    Drive::Hunting => {
                        phase += TAU * DT * self.lines[0][0] * 2.0 * (1.0 + 0.03 * (1.7 * t).sin());
                        e += open * (0.1 + 0.3 * self.size) * phase.sin();
                    }
                    _ => {}
                }
                // The oil let in by the valve, as the position that the ram would have if the oil were rigid.
                ram += DT * e / self.lag_s;
                let mut pull = omega * omega * (ram - x) - 2.0 * self.damping * omega * v;
                if self.cause == Drive::SealFriction {
                    // Friction that compresses the oil column by a share of the amplitude.
                    let bend = big * (0.01 + 0.04 * self.size);
                    let stiff = 1.0 / (big * 2e-3);
                    bristle = (bristle + DT * v) / (1.0 + DT * stiff * v.abs());
                    pull -= omega * omega * bend * stiff * bristle;
                }
                v += DT * pull;
                x += DT * v;
                match self.cause {
                    Drive::LinkPlay => {
                        let half = big * (0.01 + 0.06 * self.size);
                        link = link.clamp(x - half, x + half);
                        link
                    }
                    Drive::SecondAxis => {
                        let all = self.lines.iter().zip(&starts);
                        let sum: f64 = all.map(|([f, p], s)| (TAU * f * t + p + s).sin()).sum();
                        x + big * (0.01 + 0.03 * self.shape) * sum
                    }
                    _ => x,
                }
            })
            .collect()
    }

    /// The key.
    pub(super) fn truth(&self, plan: &Plan) -> Truth {
        let timing = ["lag_error", "delay_error", "second_lag", "oil_column"];
        let (right, beside): (&[&str], &[&str]) = match self.cause {
            Drive::Nothing | Drive::Hunting | Drive::SecondAxis => (&[], &[]),
            Drive::Slower => (&["lag_error"], &[]),
            Drive::Later => (&["delay_error"], &[]),
            Drive::Gain => (&["gain_error"], &[]),
            Drive::OilColumn => (&["oil_column", "second_lag"], &timing),
            // In a closed loop, valve overlap is lost motion, just like friction behind an elastic oil column.
            Drive::Overlap => (&["dead_band"], &timing),
            Drive::UnequalAreas => (&["asymmetric_actuator"], &timing),
            Drive::FlowLimit => (&["rate_limit", "saturation"], &timing),
            Drive::SealFriction => (&["coulomb_friction", "stribeck_friction"], &timing),
            Drive::LinkPlay => (&["backlash"], &[]),
        };
        // At one frequency everything linear is just a gain and a phase.
        let linear = matches!(self.cause, Drive::Slower | Drive::Later | Drive::OilColumn);
        Truth {
            whole: Vec::new(),
            cause: self.cause.name(),
            steps: false,
            right: right.to_vec(),
            beside: beside.to_vec(),
            nameless: matches!(self.cause, Drive::Hunting | Drive::SecondAxis),
            inseparable: linear && plan.kind == Move::OneFrequency,
        }
    }
}
