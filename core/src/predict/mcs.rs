//! Minimal control synthesis with modified demand: Bonnet, Lim, Williams, Blakeborough, Neild, Stoten and Taylor, EESD
//! 36 (2007) 119.
//!
//! MCS makes a plant follow a first-order reference model without knowing the plant: the command is `K_r r + K_x m`,
//! and both gains grow with the output error `y`, `K_r = int alpha y r + beta y r`, `K_x` likewise with the measured
//! displacement m. The modified demand inverts the reference model beforehand, `r = u + tau v`, so that its output is
//! the target itself and `y = u_c - m`. Here `K_r` starts at 1, errors are relative to the running peak, and the
//! integral parts are bounded and rate limited.
//!
//! The published beta is alpha times 0.1 s, whatever alpha. Here [`PROPORTIONAL`] is fixed. Relative to the peak, beta
//! is the mean feedback of the error over a cycle and twice that at the peaks; for an actuator with a transport delay,
//! a feedback of more than the whole error makes the command jump from sample to sample, as far as the bounds of the
//! gains allow, while the structure itself hardly moves.
//!
//! Parameters: `delay_ms`, `adaptation`. State 20 bytes per axis. Cost: some 40 operations.
//!
//! # When not to use it
//! For a pure delay its two gains are the wrong parameters: it trades amplitude for phase. The feedback of m closes a
//! loop around the actuator; `K_x` is therefore kept within [`MOST`].

use super::adaptation::{Constants, Gate, learnt};
use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::context::ActuatorContext;

/// Largest change of either gain.
const MOST: f32 = 0.5;

/// beta, relative: at the peak of the motion half of the error is fed back, so that an actuator may overdo it twice.
pub const PROPORTIONAL: f32 = 0.25;

/// One axis.
#[derive(Clone, Debug)]
pub(crate) struct Mcs {
    /// Integral parts of K_r - 1 and K_x.
    gains: [f32; 2],
    /// Modified demand in force, m.
    demand_m: f32,
    gate: Gate,
}

impl PredictAxis for Mcs {
    type Constants = Constants;

    const LEARNS: bool = true;

    fn design(context: &ActuatorContext<'_>) -> Constants {
        Constants::design(context)
    }

    fn at_rest(_: &Constants) -> Self {
        Self {
            gains: [0.0; 2],
            demand_m: 0.0,
            gate: Gate::default(),
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let demand_m = ahead.displacement_m + k.delay * ahead.velocity_m;
        let mut gains = self.gains;
        self.gate
            .open(&k.learning, followed.target_m, ahead.velocity_m);
        if self.gate.peak_m > k.learning.floor_m && followed.learn {
            let error_m = followed.target_m - followed.measured_m;
            let per_square = 1.0 / (self.gate.peak_m * self.gate.peak_m);
            for (i, signal_m) in [self.demand_m, followed.measured_m].into_iter().enumerate() {
                let drive = error_m * signal_m * per_square;
                let limit = k.learning.gain_limit;
                self.gains[i] = learnt(gains[i], k.learning.rate * drive, limit, -MOST, MOST);
                gains[i] = learnt(self.gains[i], PROPORTIONAL * drive, MOST, -MOST, MOST);
            }
        }
        self.demand_m = demand_m;
        (1.0 + gains[0]) * demand_m + gains[1] * followed.measured_m
    }

    fn unlearn(&mut self, k: &Constants) {
        for gain in &mut self.gains {
            *gain = learnt(*gain, -*gain, k.learning.gain_limit, -MOST, MOST);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks::{self, Axis};

    #[test]
    fn learns_a_gain_that_it_was_not_told() {
        let k = Constants {
            delay: 8.0,
            learning: checks::learning(),
        };
        let rest = checks::tracking_error::<Mcs>(
            &k,
            Axis {
                delay: 8,
                gain: 0.9,
            },
        );
        // Without adaptation, the demand leaves the gain error, 10 %.
        assert!(rest < 0.03, "{rest}");
    }
}
