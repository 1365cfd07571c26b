//! Feedforward-feedback: Carrion, Spencer and Phillips, Earthquake Eng. Eng. Vib. 8 (2009) 481; Phillips and Spencer,
//! J. Struct. Eng. 139 (2013) 1205.
//!
//! Feedforward is the inverse of the actuator model as a polynomial in s, `u + a_1 v + a_2 a + a_3 j`. Feedback adds a
//! fraction of the remaining tracking error, low-passed at the actuator's own delay, like the published LQG regulator
//! about the feedforward's trajectory. The jerk is the difference of two accelerations.
//!
//! Parameters: `inverse` (`[a_1, a_2, a_3]` in powers of a second; default: `tau, tau^2/2, 0` of `delay_ms`),
//! `feedback`. State 8 bytes per axis. Cost: some 20 operations.
//!
//! # When not to use it
//! It uses the declared values: no adaptation. The feedback makes a loop with the actuator, stable by the small gain
//! theorem while its share times the actuator's largest gain stays below 1.

use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::config::{Compensation, Timing};
use crate::context::ActuatorContext;
use crate::refusal::{Refusal, accept};

/// Constants of both parts, in powers of a control step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Coefficients of velocity, acceleration and jerk.
    pub inverse: [f32; 3],
    /// Fraction of the filtered error that is fed back.
    pub feedback: f32,
    /// Weight of a new error in the low-pass.
    pub smoothing: f32,
}

/// One axis.
#[derive(Clone, Debug)]
pub(crate) struct FeedforwardFeedback {
    acceleration_m: f32,
    error_m: f32,
}

impl PredictAxis for FeedforwardFeedback {
    type Constants = Constants;

    fn check(c: &Compensation, _: &Timing) -> Result<(), Refusal> {
        accept(
            "compensation.feedback",
            c.feedback,
            (0.0..1.0).contains(&c.feedback),
            "0 to below 1",
        )?;
        for &coefficient in c.inverse.iter().flatten() {
            accept(
                "compensation.inverse",
                coefficient,
                coefficient.abs() <= 10.0,
                "factors from -10 to 10, in powers of a second",
            )?;
        }
        Ok(())
    }

    fn design(context: &ActuatorContext<'_>) -> Constants {
        let c = context.parameters;
        let [a1, a2, a3] = context.inverse;
        let r = context.rate_hz;
        Constants {
            inverse: [a1 * r, a2 * r * r, a3 * r * r * r].map(|x| x as f32),
            feedback: c.feedback as f32,
            smoothing: (1.0 - libm::exp(-1.0 / context.delay_steps())) as f32,
        }
    }

    fn at_rest(_: &Constants) -> Self {
        Self {
            acceleration_m: 0.0,
            error_m: 0.0,
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let error_m = followed.target_m - followed.measured_m;
        if followed.learn {
            self.error_m += k.smoothing * (error_m - self.error_m);
        } else {
            self.error_m = 0.0;
        }
        let jerk_m = ahead.acceleration_m - self.acceleration_m;
        self.acceleration_m = ahead.acceleration_m;
        let [first, second, third] = k.inverse;
        ahead.displacement_m
            + first * ahead.velocity_m
            + second * ahead.acceleration_m
            + third * jerk_m
            + k.feedback * self.error_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks::{self, Axis};

    #[test]
    fn feedback_takes_out_a_part_of_what_the_feedforward_leaves() {
        let error = |feedback| {
            let k = Constants {
                inverse: [8.0, 32.0, 0.0],
                feedback,
                smoothing: 0.1,
            };
            checks::tracking_error::<FeedforwardFeedback>(
                &k,
                Axis {
                    delay: 8,
                    gain: 0.9,
                },
            )
        };
        let (without, with) = (error(0.0), error(0.5));
        assert!((without - 0.1).abs() < 0.01, "{without}");
        // 0.1 / (1 + 0.9 * 0.5), plus a little for the delay of the loop.
        assert!(with < 0.75 * without, "{with} of {without}");
    }

    #[test]
    fn the_third_order_matters_at_third_order() {
        let error = |third| {
            let k = Constants {
                inverse: [8.0, 32.0, third],
                feedback: 0.0,
                smoothing: 0.1,
            };
            checks::tracking_error::<FeedforwardFeedback>(
                &k,
                Axis {
                    delay: 8,
                    gain: 1.0,
                },
            )
        };
        assert!(error(512.0 / 6.0) < 0.2 * error(0.0));
    }
}
