//! Adaptive inverse compensation: Chen and Ricles, Earthquake Eng. Eng. Vib. 9 (2010) 1.
//!
//! The command is that of [`super::inverse`], and alpha follows the tracking indicator TI, half of the difference of
//! the areas that command against measured displacement and measured against command enclose. It grows by
//! `(u_last m - m_last u) / 2` per step, which for a sine is half of the peak speed squared times the remaining delay:
//! divided by that, the published `alpha = alpha_0 + k_p TI` needs no tuning. Both signals are relative to their
//! running means: a yielded specimen is off zero, and the area of that offset would outweigh the other. The published
//! `k_i` times the integral of TI is left out; TI is an integral already.
//!
//! Parameters: initial `delay_ms`, `adaptation`. State 32 bytes per axis. Cost: some 50 operations.
//!
//! # When not to use it
//! First order: the amplitude grows by `(omega tau)^2 / 2`. TI neither sees a gain error nor is affected by one.

use super::adaptation::{Constants, Gate};
use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::context::ActuatorContext;

/// The adaptive inverse on one axis.
#[derive(Clone, Debug)]
pub(crate) struct AdaptiveInverse {
    delay: f32,
    /// Target and measured displacement one control step ago.
    last_m: [f32; 2],
    /// Their running means.
    mean_m: [f32; 2],
    gate: Gate,
}

impl PredictAxis for AdaptiveInverse {
    type Constants = Constants;

    const LEARNS: bool = true;

    fn design(context: &ActuatorContext<'_>) -> Constants {
        Constants::design(context)
    }

    fn at_rest(k: &Constants) -> Self {
        Self {
            delay: k.delay,
            last_m: [0.0; 2],
            mean_m: [0.0; 2],
            gate: Gate::default(),
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let (u, m) = (followed.target_m, followed.measured_m);
        let [u_last, m_last] = self.last_m;
        let open = self.gate.open(&k.learning, u, u - u_last);
        // The indicator sums over whole cycles: it pauses only below the floor, not at a turning point.
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

    fn unlearn(&mut self, k: &Constants) {
        self.delay = k.learning.delay(self.delay, k.delay - self.delay);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks::{self, Axis};

    #[test]
    fn learns_a_delay_that_it_was_told_wrong_whatever_the_gain() {
        for gain in [1.0, 0.9] {
            let k = Constants {
                delay: 4.0,
                learning: checks::learning(),
            };
            let axis = checks::run::<AdaptiveInverse>(&k, Axis { delay: 8, gain });
            assert!((axis.0.delay - 8.0).abs() < 0.3, "{}", axis.0.delay);
        }
    }
}
