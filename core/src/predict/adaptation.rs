//! When an adaptive law may learn, and how fast.
//!
//! A law that divides by the motion learns from noise when there is none: every published failure of an adaptive
//! predictor that we know of is at the start of a test or at its quiet end. So all of them share this gate: the speed
//! must be a fair fraction of its running peak, and that peak above a floor.

use crate::config::Adaptation;
use crate::context::ActuatorContext;
use crate::float::{larger, smaller};
use crate::refusal::{Refusal, accept, between};

/// When and how fast adaptive predictors learn. Times in control steps.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Learning {
    /// Running peak of the displacement below which nothing is learnt, m.
    pub floor_m: f32,
    /// Decay factor of the running peaks per control step.
    pub memory: f32,
    /// Learning rate, 1 per control step.
    pub rate: f32,
    /// Longest delay, control steps.
    pub longest: f32,
    /// Largest change of the delay in a control step, control steps.
    pub limit: f32,
    /// Largest gain error that may be learnt, 1; 0 learns none.
    pub gain_tolerance: f32,
    /// Largest change of the gain in a control step.
    pub gain_limit: f32,
}

/// Fraction of the running peak speed below which nothing is learnt.
const SHARE: f32 = 0.3;

impl Learning {
    /// Checks the parameters.
    ///
    /// # Errors
    /// The first that cannot be accepted.
    pub fn check(a: &Adaptation) -> Result<(), Refusal> {
        between(
            "compensation.adaptation.time_s",
            a.time_s,
            1e-3,
            1e3,
            "above 0.001 and below 1000 s",
        )?;
        between(
            "compensation.adaptation.floor_m",
            a.floor_m,
            0.0,
            10.0,
            "above 0 and below 10 m",
        )?;
        between(
            "compensation.adaptation.longest_delay_ms",
            a.longest_delay_ms,
            0.0,
            1e3,
            "above 0 and below 1000 ms",
        )?;
        between(
            "compensation.adaptation.delay_rate_ms_per_s",
            a.delay_rate_ms_per_s,
            0.0,
            1e5,
            "above 0 and below 100000 ms/s",
        )?;
        accept(
            "compensation.adaptation.gain_tolerance",
            a.gain_tolerance,
            (0.0..1.0).contains(&a.gain_tolerance),
            "0 to below 1",
        )
    }

    /// The settings for a test. Running peaks fade within some natural periods of laboratory time.
    pub fn design(context: &ActuatorContext<'_>) -> Self {
        let a = &context.parameters.adaptation;
        let rate_hz = context.rate_hz;
        let per_step = context.omega / (context.time_scale * rate_hz) / core::f64::consts::TAU;
        Self {
            floor_m: a.floor_m as f32,
            memory: libm::exp(-per_step) as f32,
            rate: (1.0 / (a.time_s * rate_hz)) as f32,
            longest: (a.longest_delay_ms.max(context.delay_ms) * 1e-3 * rate_hz) as f32,
            limit: (a.delay_rate_ms_per_s * 1e-3) as f32,
            gain_tolerance: a.gain_tolerance as f32,
            gain_limit: (a.gain_tolerance / rate_hz) as f32,
        }
    }

    /// The delay after a step of learning.
    #[inline]
    pub fn delay(&self, delay: f32, step: f32) -> f32 {
        learnt(delay, step, self.limit, 0.0, self.longest)
    }

    /// The gain error after a step of learning.
    #[inline]
    pub fn gain(&self, gain: f32, step: f32) -> f32 {
        let most = self.gain_tolerance;
        learnt(gain, step, self.gain_limit, -most, most)
    }
}

/// Constants of a predictor that learns from a declared delay.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// The declared delay, control steps: the one to begin with, or the time constant of a reference model.
    pub delay: f32,
    /// How it learns.
    pub learning: Learning,
}

impl Constants {
    /// The constants for a test.
    pub fn design(context: &ActuatorContext<'_>) -> Self {
        Self {
            delay: context.delay_steps() as f32,
            learning: Learning::design(context),
        }
    }
}

/// Running peaks of the motion of one axis.
#[derive(Clone, Debug, Default)]
pub(crate) struct Gate {
    /// Running peak of the displacement, m.
    pub peak_m: f32,
    /// Running peak of the speed, m per control step.
    pub peak_speed_m: f32,
}

impl Gate {
    /// Takes in the target's motion; true if it is worth learning from.
    #[inline]
    pub fn open(&mut self, k: &Learning, displacement_m: f32, velocity_m: f32) -> bool {
        self.peak_m = larger(k.memory * self.peak_m, displacement_m.abs());
        self.peak_speed_m = larger(k.memory * self.peak_speed_m, velocity_m.abs());
        self.peak_m > k.floor_m && velocity_m.abs() > SHARE * self.peak_speed_m
    }
}

/// `value + step`, the step at most `limit` and the result between `low` and `high`; a NaN step is ignored.
#[inline]
pub fn learnt(value: f32, step: f32, limit: f32, low: f32, high: f32) -> f32 {
    if !step.is_finite() {
        return value;
    }
    let moved = value + smaller(larger(step, -limit), limit);
    smaller(larger(moved, low), high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn is_shut_at_rest_below_the_floor_and_at_a_turning_point() {
        let k = crate::predict::checks::learning();
        let mut gate = Gate::default();
        assert!(!gate.open(&k, 0.0, 0.0));
        assert!(!gate.open(&k, 0.5e-3, 1e-4), "below the floor");
        assert!(gate.open(&k, 2e-3, 1e-4));
        assert!(!gate.open(&k, 2e-3, 1e-5), "near a turning point");
        for _ in 0..10_000 {
            gate.open(&k, 0.0, 0.0);
        }
        assert!(
            !gate.open(&k, 1e-4, 1e-4),
            "a strong part that is over opens nothing"
        );
    }

    #[test]
    fn a_step_is_limited_bounded_and_never_no_number() {
        assert_eq!(learnt(1.0, 5.0, 0.5, 0.0, 10.0), 1.5);
        assert_eq!(learnt(1.0, -5.0, 2.0, 0.0, 10.0), 0.0);
        assert_eq!(learnt(1.0, f32::NAN, 0.5, 0.0, 10.0), 1.0);
        assert_eq!(learnt(1.0, f32::INFINITY, 0.5, 0.0, 10.0), 1.0);
    }
}
