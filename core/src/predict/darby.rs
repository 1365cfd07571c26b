//! Polynomial extrapolation by a delay estimated on line: Darby, Williams and Blakeborough, J. Eng. Mech. 128 (2002)
//! 1276.
//!
//! `tau' = C_p tanh(C_v v / V) e`: the tracking error `e = u_c - u_m` changes the delay while the specimen moves, and
//! the hyperbolic tangent replaces a division by the velocity, which fails at a turning point. V is the running peak of
//! the speed, so that C_p is a time; the extrapolation is that of [`super::lagrange`].
//!
//! Parameters: initial `delay_ms`, `order`, `adaptation`. State 276 bytes per axis. Cost: that of `lagrange` and some
//! 30 operations.
//!
//! # When not to use it
//! A gain error looks like a delay half of the time, and biases it. Otherwise see [`super::lagrange`].

use super::adaptation::{Gate, Learning};
use super::interface::{LastCommand, PredictAxis, TargetMotion};
use super::lagrange::Extrapolation;
use super::past::PastTargets;
use crate::context::ActuatorContext;
use crate::float::{larger, smaller};

/// C_v: at half of the peak speed the law has three quarters of its full effect.
const STEEPNESS: f32 = 2.0;

/// Constants of the prediction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Initial delay, control steps.
    pub delay: f32,
    /// How it is learnt.
    pub learning: Learning,
    /// The polynomial.
    pub extrapolation: Extrapolation,
}

/// What has been learnt of one axis.
#[derive(Clone, Debug)]
pub(crate) struct Darby {
    delay: f32,
    /// Velocity of the target in force, m per control step.
    velocity_m: f32,
    gate: Gate,
    past: PastTargets,
}

impl PredictAxis for Darby {
    type Constants = Constants;

    const LEARNS: bool = true;

    fn design(context: &ActuatorContext<'_>) -> Constants {
        let learning = Learning::design(context);
        let order = context.parameters.order;
        Constants {
            delay: context.delay_steps() as f32,
            learning,
            extrapolation: Extrapolation::new(order, f64::from(learning.longest)),
        }
    }

    fn at_rest(k: &Constants) -> Self {
        Self {
            delay: k.delay,
            velocity_m: 0.0,
            gate: Gate::default(),
            past: PastTargets::at_rest(),
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let (u, v) = (followed.target_m, self.velocity_m);
        if self.gate.open(&k.learning, u, v) && followed.learn {
            let error = followed.target_m - followed.measured_m;
            let peak = self.gate.peak_speed_m;
            let step = k.learning.rate * error * tanh(STEEPNESS * v / peak) / peak;
            self.delay = k.learning.delay(self.delay, step);
        }
        self.velocity_m = ahead.velocity_m;
        k.extrapolation
            .ahead(&mut self.past, ahead.displacement_m, self.delay)
    }

    fn unlearn(&mut self, k: &Constants) {
        self.delay = k.learning.delay(self.delay, k.delay - self.delay);
    }
}

/// Within .025 of the hyperbolic tangent, with its slope at 0 and its limit from 3 on.
#[inline]
fn tanh(x: f32) -> f32 {
    let x = larger(smaller(x, 3.0), -3.0);
    x * (27.0 + x * x) / (27.0 + 9.0 * x * x)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks::{self, Axis};

    #[test]
    fn the_short_tangent_is_close() {
        for i in -500..500 {
            let x = i as f32 * 0.01;
            assert!((tanh(x) - libm::tanhf(x)).abs() < 0.025, "{x}");
        }
    }

    #[test]
    fn learns_a_delay_that_it_was_told_wrong() {
        let k = Constants {
            delay: 4.0,
            learning: checks::learning(),
            extrapolation: Extrapolation::new(3, 40.0),
        };
        let rest = checks::tracking_error::<Darby>(
            &k,
            Axis {
                delay: 8,
                gain: 1.0,
            },
        );
        assert!(rest < 1e-3, "{rest}");
    }
}
