//! Adaptive forward prediction: Wallace, Wagg and Neild, Proc. R. Soc. A 461 (2005) 3807.
//!
//! The command is the motion one delay ahead, `(1 + g) (u + tau v + tau^2/2 a)`; the delay tau and the gain error g are
//! learnt from the tracking error `e = u_c - u_m`, which is `tau_rest v + g_rest u` while something is left to learn.
//! Wallace fits a polynomial to past targets; here the integration knows v and a, so no fit is needed. The law is a
//! normalised gradient: `tau' = mu e v / V`, `g' = mu e u / U` with V and U the running peaks of v^2 and u^2.
//!
//! `u + tau v + tau^2/2 a` is a pure delay to second order, and exactly the inverse of a second-order actuator with a
//! damping ratio of .707.
//!
//! Parameters: initial `delay_ms`, `adaptation`. State 20 bytes per axis. Cost: some 40 operations.
//!
//! # When not to use it
//! Beyond `omega tau` of about 1 for the highest active mode: the second-order term amplifies it. For an actuator that
//! is neither a delay nor a second-order lag, [`super::ats`] fits more of it.

use super::adaptation::{Constants, Gate};
use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::context::ActuatorContext;

/// What has been learnt of one axis.
#[derive(Clone, Debug)]
pub(crate) struct Afp {
    delay: f32,
    gain: f32,
    /// Velocity of the target in force, m per control step.
    velocity_m: f32,
    gate: Gate,
}

impl PredictAxis for Afp {
    type Constants = Constants;

    const LEARNS: bool = true;

    fn design(context: &ActuatorContext<'_>) -> Constants {
        Constants::design(context)
    }

    fn at_rest(k: &Constants) -> Self {
        Self {
            delay: k.delay,
            gain: 0.0,
            velocity_m: 0.0,
            gate: Gate::default(),
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let k = &k.learning;
        let (u, v) = (followed.target_m, self.velocity_m);
        if self.gate.open(k, u, v) && followed.learn {
            let error = followed.target_m - followed.measured_m;
            let peak = self.gate.peak_speed_m;
            let step = k.rate * error * v / (v * v + 0.1 * peak * peak);
            self.delay = k.delay(self.delay, step);
            let step = k.rate * error * u / (self.gate.peak_m * self.gate.peak_m);
            self.gain = k.gain(self.gain, step);
        }
        self.velocity_m = ahead.velocity_m;
        (1.0 + self.gain) * ahead.after(self.delay)
    }

    fn unlearn(&mut self, k: &Constants) {
        self.delay = k.learning.delay(self.delay, k.delay - self.delay);
        self.gain = k.learning.gain(self.gain, -self.gain);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks::{self, Axis};

    #[test]
    fn learns_a_delay_and_a_gain_that_it_was_told_wrong() {
        let k = Constants {
            delay: 4.0,
            learning: checks::learning(),
        };
        let rest = checks::tracking_error::<Afp>(
            &k,
            Axis {
                delay: 8,
                gain: 0.95,
            },
        );
        assert!(rest < 2e-3, "{rest}");
    }
}
