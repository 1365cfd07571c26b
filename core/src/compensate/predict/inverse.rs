//! Inverse compensation: Chen and Ricles, J. Struct. Eng. 135 (2009) 1017 and Earthquake Eng. Eng. Vib. 9 (2010) 1.
//!
//! The actuator is taken to reach the command in `alpha` control steps, `G(z) = z / (alpha z - (alpha - 1))`, and the
//! command is the target through the inverse: `u + (alpha - 1)(u - u_last)`. With `alpha - 1` the delay in steps.
//!
//! The adaptive form moves alpha by the tracking indicator TI, half of the difference of the areas that command against
//! measured displacement and measured against command enclose. It grows by `(u_last m - m_last u) / 2` a step, which
//! for a sine is half of the peak speed squared times the delay that is left: divided by that, the published
//! `alpha = alpha_0 + k_p TI` needs no tuning. Both signals are taken about their running means: a yielded
//! specimen stands off zero, and the area of that offset would outweigh the other. The published `k_i` times the integral of TI is left out; TI is an
//! integral already.
//!
//! Parameters: `delay_ms`; adaptive also `adaptation`. State 4 or 32 bytes an axis. Cost: 4 or some 50 operations.
//!
//! # When not to use it
//! First order: the amplitude grows by `(omega tau)^2 / 2`. TI does not see a gain error, and does not mind one.

use super::gate::{Gate, Learning};
use super::{Ahead, Followed, Predict};

/// Constants of the fixed inverse.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    /// alpha - 1.
    pub delay: f32,
}

/// The fixed inverse on one axis.
#[derive(Clone, Debug)]
pub struct Inverse;

impl Predict for Inverse {
    type Constants = Constants;

    fn at_rest(_: &Constants) -> Self {
        Self
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &Followed, ahead: &Ahead) -> f32 {
        let u = ahead.displacement_m;
        u + k.delay * (u - followed.target_m)
    }
}

/// Constants of the adaptive inverse.
#[derive(Clone, Copy, Debug)]
pub struct AdaptiveConstants {
    /// alpha - 1 to start with.
    pub delay: f32,
    /// How it is learnt.
    pub learning: Learning,
}

/// The adaptive inverse on one axis.
#[derive(Clone, Debug)]
pub struct AdaptiveInverse {
    delay: f32,
    /// Target and measured displacement one control step ago.
    last_m: [f32; 2],
    /// Their running means.
    mean_m: [f32; 2],
    gate: Gate,
}

impl Predict for AdaptiveInverse {
    type Constants = AdaptiveConstants;

    fn at_rest(k: &AdaptiveConstants) -> Self {
        Self {
            delay: k.delay,
            last_m: [0.0; 2],
            mean_m: [0.0; 2],
            gate: Gate::default(),
        }
    }

    #[inline]
    fn command(&mut self, k: &AdaptiveConstants, followed: &Followed, ahead: &Ahead) -> f32 {
        let (u, m) = (followed.target_m, followed.measured_m);
        let [u_last, m_last] = self.last_m;
        let open = self.gate.open(&k.learning, u, u - u_last);
        // The indicator adds up over whole cycles: only the floor stops it, not a turning point.
        if (open || self.gate.peak_m > k.learning.floor_m) && followed.learn {
            let [c, d] = self.mean_m;
            let area = (u_last - c) * (m - d) - (m_last - d) * (u - c);
            let peak = self.gate.peak_speed_m;
            let step = k.learning.rate * area / (peak * peak);
            self.delay = k.learning.delay(self.delay, step);
        }
        for (mean, now) in self.mean_m.iter_mut().zip([u, m]) {
            *mean += (1.0 - k.learning.memory) * (now - *mean);
        }
        self.last_m = [u, m];
        let next = ahead.displacement_m;
        next + self.delay * (next - u)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compensate::predict::checks::{self, Axis};

    #[test]
    fn the_inverse_of_its_own_actuator_is_exact() {
        let k = Constants { delay: 7.0 };
        let (mut axis, mut moved, mut target) = (Inverse::at_rest(&k), 0.0_f32, 0.0_f32);
        for i in 0..500 {
            let next = libm::sinf(0.01 * i as f32);
            let followed = Followed {
                target_m: target,
                ..checks::AT_REST
            };
            let ahead = Ahead {
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

    #[test]
    fn learns_a_delay_that_it_was_told_wrong_whatever_the_gain() {
        for gain in [1.0, 0.9] {
            let k = AdaptiveConstants {
                delay: 4.0,
                learning: checks::learning(),
            };
            let axis = checks::run::<AdaptiveInverse>(&k, Axis { delay: 8, gain });
            assert!((axis.0.delay - 8.0).abs() < 0.3, "{}", axis.0.delay);
        }
    }
}
