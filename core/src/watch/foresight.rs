//! The error that a named cause will have added by the end of the test.
//!
//! A cause is treated as a change of the force in the equation of motion, in phase with the displacement (`re`,
//! relative to the stiffness) and in phase with the velocity (`im`, which feeds the motion: a lateness `tau` is
//! `omega tau`). Near the structure's frequency the error of the amplitude then grows by
//!
//! ```text
//! e' = omega (|re + i im| a / 2 - z e),   z = zeta - im / 2
//! ```
//!
//! to first order, as if its phase stayed; `a` is the planned amplitude, taken as constant over each of [`PARTS`] parts
//! of the test. If `z` is below 0 the error grows by itself. An offset is an error as large as itself, a drift a
//! growing one. Sensor errors that no controller follows, and changes of the specimen itself, do not count.

use super::declared::Declared;
use super::name::Cause;
use super::state::Finding;
use crate::float::{larger, smaller};
use core::f32::consts::{PI, SQRT_2};

/// sqrt(3).
const SQRT_3: f32 = 1.732_050_8;

/// Parts of a test, over each of which the planned motion is one number.
pub const PARTS: usize = 16;

/// Where a test is to be stopped, and what the structure and the test are.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ErrorLimit {
    /// Largest predicted error of the whole test, rms, of the planned peak.
    pub largest: f64,
    /// Damping ratio of the first mode.
    pub damping_ratio: f64,
    /// Length of the test, s of the laboratory.
    pub duration_s: f64,
    /// Planned displacement of each part of the test, rms, of the planned peak.
    pub planned_rms: [f64; PARTS],
}

/// The inputs to the prediction.
#[derive(Clone, Debug)]
pub(super) struct Foresight {
    largest: f32,
    damping_ratio: f32,
    omega: f32,
    peak_m: f32,
    stiffness: f32,
    duration_s: f32,
    amplitude: [f32; PARTS],
}

/// Beyond this many time constants a growing error is large anyway.
const LONGEST: f32 = 20.0;

impl Foresight {
    pub(super) fn new(d: &Declared, limit: &ErrorLimit) -> Self {
        Self {
            largest: limit.largest as f32,
            damping_ratio: limit.damping_ratio as f32,
            omega: d.omega_rad_per_s as f32,
            peak_m: d.peak_m as f32,
            stiffness: d.stiffness_n_per_m as f32,
            duration_s: limit.duration_s as f32,
            amplitude: limit.planned_rms.map(|rms| SQRT_2 * rms as f32),
        }
    }

    /// The largest permitted error, as declared.
    pub(super) fn largest(&self) -> f32 {
        self.largest
    }

    /// The rms error over the whole test that a cause adds if it acts from `from_s` on, relative to the planned peak;
    /// `corrected` is the part of its value that is already compensated.
    pub(super) fn error(&self, f: &Finding, corrected: f32, from_s: f32) -> f32 {
        let rest = larger(1.0 - from_s / self.duration_s, 0.0);
        let value = (f.value - corrected) / f.cause.per_si();
        match self.change(f.cause, value, rest * self.duration_s) {
            Change::None => 0.0,
            Change::Offset(share) => share.abs() * libm::sqrtf(rest),
            Change::Force([re, im]) => self.grown(re, im, 1.0 - rest),
        }
    }

    /// The error envelope from the fraction `from` of the test on, as rms over the whole test.
    fn grown(&self, re: f32, im: f32, from: f32) -> f32 {
        let z = self.damping_ratio - 0.5 * im;
        let feeds = 0.5 * libm::sqrtf(re * re + im * im);
        let part = self.omega * self.duration_s / PARTS as f32;
        let (mut e, mut square) = (0.0_f32, 0.0_f32);
        for (i, amplitude) in self.amplitude.iter().enumerate() {
            let share = smaller(larger((i + 1) as f32 - from * PARTS as f32, 0.0), 1.0);
            let time = larger(smaller(z * part * share, LONGEST), -LONGEST);
            let gone = -libm::expm1f(-time);
            // (1 - exp(-z w t)) / z, whose limit at z = 0 is w t.
            let grown = if time.abs() < 1e-3 {
                part * share
            } else {
                gone / z
            };
            let before = e;
            e += feeds * amplitude * grown - gone * e;
            // Mean square of a nearly linear envelope.
            square += share * (before * before + before * e + e * e) / 3.0;
        }
        libm::sqrtf(square / (2.0 * PARTS as f32))
    }

    fn change(&self, cause: Cause, value: f32, rest_s: f32) -> Change {
        let force = self.peak_m * self.stiffness;
        // Friction: the first harmonic of a square wave.
        let rub = |share: f32| 4.0 / PI * share.abs();
        let (re, im) = match cause {
            Cause::ActuatorLate | Cause::ForceLate => (0.0, self.omega * value),
            Cause::ActuatorGain | Cause::ForceGain => (value, 0.0),
            Cause::ActuatorOffset => return Change::Offset(value / self.peak_m),
            Cause::ForceOffset => return Change::Offset(value / force),
            // Rms of a line that starts at 0.
            Cause::ForceDrift => return Change::Offset(value * rest_s / (SQRT_3 * force)),
            Cause::ActuatorDrift => return Change::Offset(value * rest_s / (SQRT_3 * self.peak_m)),
            Cause::ActuatorFriction => (0.0, rub(value / self.peak_m)),
            Cause::BearingFriction => (0.0, -rub(value / force)),
            Cause::RateLimit => (value / (self.omega * self.peak_m) - 1.0, 0.0),
            Cause::StrokeLimit => (value / self.peak_m - 1.0, 0.0),
            Cause::Mass => (-value * self.omega * self.omega / self.stiffness, 0.0),
            Cause::Play => (-value / self.peak_m, 0.0),
            Cause::ActuatorOverlap => (-0.5 * rub(value / self.peak_m), 0.0),
            Cause::DisplacementGain
            | Cause::DisplacementOffset
            | Cause::DisplacementLate
            | Cause::StiffnessLoss
            | Cause::FrozenDisplacement
            | Cause::FrozenForce
            | Cause::DisplacementNoise
            | Cause::ForceNoise
            | Cause::DisplacementHum
            | Cause::ForceHum
            | Cause::DisplacementDrift => return Change::None,
        };
        Change::Force([re, im])
    }
}

/// The effect of a cause on the motion.
#[derive(Clone, Copy, Debug)]
enum Change {
    None,
    /// A constant error, as a fraction of the planned peak.
    Offset(f32),
    /// A force change in phase with displacement and velocity, relative to the stiffness.
    Force([f32; 2]),
}

#[cfg(test)]
mod tests {
    use super::*;

    const OMEGA: f32 = core::f32::consts::TAU;

    /// A motion planned to fade from 1 to a half.
    fn foresight() -> Foresight {
        Foresight {
            largest: 0.1,
            damping_ratio: 0.03,
            omega: OMEGA,
            peak_m: 0.04,
            stiffness: 158e3,
            duration_s: 16.0,
            amplitude: core::array::from_fn(|i| 1.0 - i as f32 / 32.0),
        }
    }

    fn error(cause: Cause, value: f32, corrected: f32, from_s: f32) -> f32 {
        let finding = Finding {
            cause,
            value,
            sd: 0.0,
        };
        foresight().error(&finding, corrected, from_s)
    }

    /// The envelope equation from the head of this file, integrated step by step.
    fn integrated(re: f64, im: f64, from_s: f64) -> f64 {
        let (w, zeta, h) = (f64::from(OMEGA), 0.03, 1e-4);
        let (mut e, mut square, mut t) = (0.0, 0.0, from_s);
        while t < 16.0 {
            let amplitude = f64::from(foresight().amplitude[t as usize]);
            e += h * w * (0.5 * re.hypot(im) * amplitude - (zeta - 0.5 * im) * e);
            square += h * e * e;
            t += h;
        }
        libm::sqrt(square / 32.0)
    }

    #[test]
    fn it_is_what_the_envelope_comes_to_damped_undamped_and_growing() {
        // At 9.55 ms the energy fed in equals the structure's own dissipation.
        for late_ms in [2.0, 0.06 / 6.283e-3, 14.0] {
            for from_s in [0.0, 6.5, 15.2] {
                let own = error(Cause::ActuatorLate, late_ms as f32, 0.0, from_s as f32);
                let right = integrated(0.0, f64::from(OMEGA) * 1e-3 * late_ms, from_s);
                assert!(
                    (f64::from(own) / right - 1.0).abs() < 0.02,
                    "{late_ms} ms from {from_s} s: {own}, {right}"
                );
            }
        }
        let gain = error(Cause::ForceGain, -0.1, 0.0, 4.0);
        assert!((f64::from(gain) / integrated(-0.1, 0.0, 4.0) - 1.0).abs() < 0.02);
    }

    #[test]
    fn what_is_corrected_adds_nothing_and_a_broken_specimen_is_no_error() {
        let late = |corrected| error(Cause::ActuatorLate, 12.0, corrected, 4.0);
        assert!(late(12.0).abs() < 1e-6);
        assert!(late(6.0) < 0.5 * late(0.0));
        assert_eq!(error(Cause::StiffnessLoss, -0.5, 0.0, 0.0), 0.0);
        let offset = error(Cause::ActuatorOffset, 4.0, 0.0, 12.0);
        assert!(
            (offset - 0.05).abs() < 1e-6,
            "a tenth for a quarter of the time: {offset}"
        );
    }
}
