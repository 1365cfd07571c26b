//! Inverse compensation: Chen and Ricles, J. Struct. Eng. 135 (2009) 1017.
//!
//! The actuator is assumed to reach the command in `alpha` control steps, `G(z) = z / (alpha z - (alpha - 1))`, and the
//! command is the target through the inverse: `u + (alpha - 1)(u - u_last)`. `alpha - 1` is the delay in steps.
//!
//! Parameters: `delay_ms`. No state. Cost: 4 operations.
//!
//! # When not to use it
//! First order: the amplitude grows by `(omega tau)^2 / 2`. It relies on the declared delay.

use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::context::ActuatorContext;

/// Constants of the inverse.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// alpha - 1.
    pub delay: f32,
}

/// The inverse on one axis.
#[derive(Clone, Debug)]
pub(crate) struct Inverse;

impl PredictAxis for Inverse {
    type Constants = Constants;

    fn design(context: &ActuatorContext<'_>) -> Constants {
        Constants {
            delay: context.delay_steps() as f32,
        }
    }

    fn at_rest(_: &Constants) -> Self {
        Self
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let u = ahead.displacement_m;
        u + k.delay * (u - followed.target_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks;

    #[test]
    fn the_inverse_of_its_own_actuator_is_exact() {
        let k = Constants { delay: 7.0 };
        let (mut axis, mut moved, mut target) = (Inverse::at_rest(&k), 0.0_f32, 0.0_f32);
        for i in 0..500 {
            let next = libm::sinf(0.01 * i as f32);
            let followed = LastCommand {
                target_m: target,
                ..checks::AT_REST
            };
            let ahead = TargetMotion {
                displacement_m: next,
                velocity_m: 0.0,
                acceleration_m: 0.0,
            };
            let sent = axis.command(&k, &followed, &ahead);
            // alpha m_i - (alpha - 1) m_{i-1} = sent.
            moved = (sent + 7.0 * moved) / 8.0;
            target = next;
            assert!((moved - target).abs() < 1e-5);
        }
    }
}
