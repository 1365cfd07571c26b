//! Adaptive model-based compensation: Galmez and Fermandois, Structural Control and Health Monitoring 29 (2022).
//!
//! Feedforward is `a_0 u + a_1 v + a_2 a + a_3 j`, the inverse of a third-order actuator. Its coefficients are learnt from
//! the response to the commands: with phi the measured displacement and its first three backward differences, and `e`
//! the sent command minus `a . phi`, `a' = Gamma phi e / (1 + phi . phi)`. Command and phi pass the same
//! fourth-order Butterworth filter first, so that its lag cancels. Coefficients stay at 0 or above. The gain `a_0` is
//! relative to the command's gain that the rig is calibrated with.
//!
//! Parameters: `inverse` (`[a_1, a_2, a_3]` to begin with; left out: those of `delay_ms`), `amb.gains` (Gamma, in powers of
//! metre and second), `amb.smoothing_hz`. State 180 bytes an axis. Cost: some 150 operations.
//!
//! # When not to use it
//! The law is scaled by `1 + phi . phi` in SI units, where the square of the jerk rules: gains that were tuned for one
//! size of motion are not those of another. It learns the sensor's noise while the test does not move.

use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::config::{Compensation, Timing};
use crate::context::ActuatorContext;
use crate::estimate::prewarped;
use crate::float::{larger, smaller};
use crate::method::Prediction;
use crate::refusal::{Refusal, accept, between};

/// Fraction of what was learnt that is taken back per second, if it has to be.
const UNLEARNS_A_SECOND: f32 = 4.0;

/// Constants of the compensator; derivatives in powers of a control step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Coefficients to begin with; the first belongs to the displacement.
    pub start: [f32; 4],
    /// Gamma times the control step, over the powers of it that the coefficients have.
    pub gains: [f32; 4],
    /// Derivatives in SI units per derivative in control steps.
    pub per_step: [f32; 4],
    /// The two sections of the Butterworth filter.
    pub sections: [Section; 2],
}

/// A second-order low-pass by the trapezoidal rule, in the state variables that keep its precision in f32 however far
/// below the rate its cut-off is.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    first: f32,
    second: f32,
    third: f32,
}

impl Section {
    /// With the cut-off `hz`, a damping of `ratio`, at `rate_hz`.
    fn new(hz: f64, ratio: f64, rate_hz: f64) -> Self {
        let g = prewarped(hz, rate_hz);
        let first = 1.0 / (1.0 + g * (g + 2.0 * ratio));
        Self {
            first: first as f32,
            second: (g * first) as f32,
            third: (g * g * first) as f32,
        }
    }

    #[inline]
    fn pass(&self, state: &mut [f32; 2], input: f32) -> f32 {
        let rest = input - state[1];
        let band = self.first * state[0] + self.second * rest;
        let low = state[1] + self.second * state[0] + self.third * rest;
        *state = [2.0 * band - state[0], 2.0 * low - state[1]];
        low
    }
}

/// The fourth-order Butterworth filter's two sections: their damping ratios are sine and cosine of pi / 8.
fn butterworth(hz: f64, rate_hz: f64) -> [Section; 2] {
    use core::f64::consts::SQRT_2;
    [2.0 - SQRT_2, 2.0 + SQRT_2].map(|x| Section::new(hz, 0.5 * libm::sqrt(x), rate_hz))
}

/// One axis.
#[derive(Clone, Debug)]
pub(crate) struct Amb {
    coefficients: [f32; 4],
    /// Measured displacement and its first two differences a control step ago.
    measured: [f32; 3],
    acceleration_m: f32,
    /// Filters of the command and of phi.
    command: [[f32; 2]; 2],
    phi: [[[f32; 2]; 2]; 4],
}

impl PredictAxis for Amb {
    type Constants = Constants;

    const LEARNS: bool = true;

    fn check(c: &Compensation, t: &Timing) -> Result<(), Refusal> {
        for gain in c.amb.gains {
            accept(
                "compensation.amb.gains",
                gain,
                (0.0..1e12).contains(&gain),
                "four numbers, 0 or above and below 1e12",
            )?;
        }
        if c.kind.predictor == Prediction::Amb {
            between(
                "compensation.amb.smoothing_hz",
                c.amb.smoothing_hz,
                0.0,
                t.rate_hz / 20.0,
                "above 0 and below a twentieth of loop.rate_hz",
            )?;
        }
        Ok(())
    }

    fn design(context: &ActuatorContext<'_>) -> Constants {
        let c = context.parameters;
        let [a1, a2, a3] = context.inverse;
        let r = context.rate_hz;
        let powers = [1.0, r, r * r, r * r * r];
        let [g0, g1, g2, g3] = c.amb.gains;
        // A coefficient in control steps is the rate's power times that in seconds; phi in seconds the same times phi in
        // control steps.
        let gain = |g: f64, power: f64| (g * power * power / r) as f32;
        Constants {
            start: [1.0, a1 * r, a2 * r * r, a3 * r * r * r].map(|x| x as f32),
            gains: [
                gain(g0, powers[0]),
                gain(g1, powers[1]),
                gain(g2, powers[2]),
                gain(g3, powers[3]),
            ],
            per_step: powers.map(|x| x as f32),
            sections: butterworth(c.amb.smoothing_hz, r),
        }
    }

    fn at_rest(k: &Constants) -> Self {
        Self {
            coefficients: k.start,
            measured: [0.0; 3],
            acceleration_m: 0.0,
            command: [[0.0; 2]; 2],
            phi: [[[0.0; 2]; 2]; 4],
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let sent = smooth(k, &mut self.command, followed.sent_m);
        let [m, m1, m2] = self.measured;
        let first = followed.measured_m - m;
        let second = first - m1;
        self.measured = [followed.measured_m, first, second];
        let differences = [followed.measured_m, first, second, second - m2];
        let mut phi = [0.0; 4];
        for i in 0..4 {
            phi[i] = smooth(k, &mut self.phi[i], differences[i]);
        }
        if followed.learn {
            let (mut rest, mut size) = (sent, 1.0);
            for i in 0..4 {
                rest -= self.coefficients[i] * phi[i];
                let si = k.per_step[i] * phi[i];
                size += si * si;
            }
            let rate = rest / size;
            for i in 0..4 {
                let learnt = self.coefficients[i] + k.gains[i] * phi[i] * rate;
                if learnt.is_finite() {
                    self.coefficients[i] = larger(learnt, 0.0);
                }
            }
        }
        let jerk_m = ahead.acceleration_m - self.acceleration_m;
        self.acceleration_m = ahead.acceleration_m;
        let [a0, a1, a2, a3] = self.coefficients;
        a0 * ahead.displacement_m + a1 * ahead.velocity_m + a2 * ahead.acceleration_m + a3 * jerk_m
    }

    fn unlearn(&mut self, k: &Constants) {
        let share = smaller(UNLEARNS_A_SECOND / k.per_step[1], 1.0);
        for (coefficient, start) in self.coefficients.iter_mut().zip(k.start) {
            *coefficient += share * (start - *coefficient);
        }
    }
}

#[inline]
fn smooth(k: &Constants, states: &mut [[f32; 2]; 2], input: f32) -> f32 {
    let mut value = input;
    for (section, state) in k.sections.iter().zip(states) {
        value = section.pass(state, value);
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks::{self, Axis};

    /// Of a pure delay in control steps at 2 kHz, with `told` of it declared.
    fn constants(told: f32) -> Constants {
        let rate = 2000.0_f32;
        let gain = |g: f32, power: f32| g * power * power / rate;
        Constants {
            start: [1.0, told, 0.5 * told * told, told * told * told / 6.0],
            // Tuned for a motion of 20 mm at 2 Hz, whose jerk is 40 m/s^3.
            gains: [gain(1e8, 1.0), gain(1e6, rate), gain(1e3, rate * rate), 0.0],
            per_step: [1.0, rate, rate * rate, rate * rate * rate],
            sections: butterworth(20.0, 2000.0),
        }
    }

    #[test]
    fn learns_a_delay_and_a_gain_that_it_was_told_wrong() {
        let actuator = Axis {
            delay: 8,
            gain: 0.95,
        };
        let mut fixed = constants(4.0);
        fixed.gains = [0.0; 4];
        let told = checks::tracking_error::<Amb>(&fixed, actuator);
        let learnt = checks::tracking_error::<Amb>(&constants(4.0), actuator);
        assert!(told > 0.05 && learnt < 0.1 * told, "{learnt} of {told}");
    }

    #[test]
    fn the_filter_is_a_butterworth_of_fourth_order() {
        let sections = butterworth(20.0, 2000.0);
        for (hz, wanted) in [(2.0, 1.0), (20.0, 0.5_f64.sqrt()), (80.0, 1.0 / 256.0)] {
            let (mut states, mut peak) = ([[0.0; 2]; 2], 0.0_f32);
            for i in 0..8000 {
                let phase = core::f64::consts::TAU * hz / 2000.0 * f64::from(i);
                let mut value = libm::sin(phase) as f32;
                for (section, state) in sections.iter().zip(&mut states) {
                    value = section.pass(state, value);
                }
                if i > 4000 {
                    peak = larger(peak, value.abs());
                }
            }
            // The trapezoidal rule warps frequencies: 80 Hz by half a per cent.
            assert!(
                (f64::from(peak) / wanted - 1.0).abs() < 0.05,
                "{hz} Hz: {peak}"
            );
        }
    }

    #[test]
    fn coefficients_stay_at_zero_or_above_and_a_reading_that_is_none_teaches_nothing() {
        let k = constants(4.0);
        let mut axis = Amb::at_rest(&k);
        let followed = |measured_m: f32| LastCommand {
            target_m: 0.0,
            sent_m: 0.01,
            measured_m,
            learn: true,
        };
        let ahead = TargetMotion {
            displacement_m: 0.01,
            velocity_m: 0.0,
            acceleration_m: 0.0,
        };
        for _ in 0..20_000 {
            axis.command(&k, &followed(-0.02), &ahead);
        }
        assert!(axis.coefficients.iter().all(|&a| a >= 0.0));
        assert_eq!(axis.coefficients[0], 0.0, "the reading has the wrong sign");
        let before = axis.coefficients;
        axis.command(&k, &followed(f32::NAN), &ahead);
        assert_eq!(axis.coefficients, before);
    }
}
