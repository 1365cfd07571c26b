//! Adaptive time series: Chae, Kazemibidokhti and Ricles, EESD 42 (2013) 1697.
//!
//! The command is `a_0 u + a_1 v + a_2 a` of the target, and the three coefficients are those that best explain what
//! was sent by what was measured, `sent = a_0 m + a_1 m' + a_2 m''`, over the last second or so. As laboratories use it
//! today: sent and measured displacement pass the same low-pass, whose own states give the derivatives without a
//! difference; nothing is learnt below a threshold of motion; coefficients are bounded and rate limited.
//!
//! The moving window of 1024 samples is an exponential one here (six and three sums in place of 4 kB), and the least
//! squares are drawn towards the coefficients of the start by a ridge: for a response of a single frequency a is
//! -omega^2 u, and `a_0` and `a_2` cannot be told apart.
//!
//! Parameters: `inverse` to start with, or `delay_ms`; `adaptation` (its `time_s` times 12.5 is the window),
//! `smoothing_hz`. State 112 bytes an axis. Cost: some 120 operations.
//!
//! # When not to use it
//! If a higher mode is already near its limit with the initial coefficients: it does not wait for the learning.
//! If noise moves more than the test does: the regression has errors in its variables, and they bias it low.

use super::adaptation::{Gate, Learning, learnt};
use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::config::{Compensation, Timing};
use crate::context::ActuatorContext;
use crate::method::Prediction;
use crate::refusal::{Refusal, between};

/// Weight of the prior, as a share of the mean square of the three signals.
const RIDGE: f32 = 1e-4;

/// Constants of the compensator. Derivatives are taken in units of the fundamental period, so that the three signals
/// are of one size.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Second and third coefficient to start with, in units.
    pub start: [f32; 2],
    /// 1 / omega of the fundamental period, control steps.
    pub unit: f32,
    /// Square of the low-pass's angular frequency, 1 / control step^2.
    pub stiffness: f32,
    /// Its damping, 1 / control step.
    pub damping: f32,
    /// Decay factor of the sums per control step.
    pub memory: f32,
    /// When to learn.
    pub learning: Learning,
}

/// A second-order low-pass whose states are the filtered signal and its derivative.
#[derive(Clone, Copy, Debug, Default)]
struct Smooth {
    value: f32,
    speed: f32,
}

impl Smooth {
    /// Takes in a value; returns filtered value, speed and acceleration at the end of the step.
    #[inline]
    fn pass(&mut self, k: &Constants, input: f32) -> [f32; 3] {
        let acceleration = k.stiffness * (input - self.value) - k.damping * self.speed;
        self.speed += acceleration;
        self.value += self.speed;
        // The speed is that of the middle of the step.
        [self.value, self.speed + 0.5 * acceleration, acceleration]
    }
}

/// One axis.
#[derive(Clone, Debug)]
pub(crate) struct Ats {
    coefficients: [f32; 3],
    sent: Smooth,
    measured: Smooth,
    /// Sums of z z^T (upper triangle) and z y.
    squares: [f32; 6],
    products: [f32; 3],
    gate: Gate,
}

impl PredictAxis for Ats {
    type Constants = Constants;

    const LEARNS: bool = true;

    fn check(c: &Compensation, t: &Timing) -> Result<(), Refusal> {
        if c.kind.predictor != Prediction::Ats {
            return Ok(());
        }
        between(
            "compensation.adaptation.smoothing_hz",
            c.adaptation.smoothing_hz,
            0.0,
            t.rate_hz / 20.0,
            "above 0 and below a twentieth of loop.rate_hz",
        )
    }

    fn design(context: &ActuatorContext<'_>) -> Constants {
        let a = &context.parameters.adaptation;
        let pass = core::f64::consts::TAU * a.smoothing_hz / context.rate_hz;
        let unit_s = context.time_scale / context.omega;
        let [first, second, _] = context.inverse;
        Constants {
            start: [first / unit_s, second / (unit_s * unit_s)].map(|x| x as f32),
            unit: (context.rate_hz * unit_s) as f32,
            stiffness: (pass * pass) as f32,
            damping: (core::f64::consts::SQRT_2 * pass) as f32,
            memory: libm::exp(-1.0 / (12.5 * a.time_s * context.rate_hz)) as f32,
            learning: Learning::design(context),
        }
    }

    fn at_rest(k: &Constants) -> Self {
        Self {
            coefficients: [1.0, k.start[0], k.start[1]],
            sent: Smooth::default(),
            measured: Smooth::default(),
            squares: [0.0; 6],
            products: [0.0; 3],
            gate: Gate::default(),
        }
    }

    #[inline]
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let [sent, ..] = self.sent.pass(k, followed.sent_m);
        let [m, m1, m2] = self.measured.pass(k, followed.measured_m);
        self.gate
            .open(&k.learning, followed.target_m, ahead.velocity_m);
        if self.gate.peak_m > k.learning.floor_m && followed.learn {
            let z = [m, m1 * k.unit, m2 * k.unit * k.unit];
            let start = [1.0, k.start[0], k.start[1]];
            let [a, b, c] = start;
            // The residual of the prior.
            let y = sent - (a * z[0] + b * z[1] + c * z[2]);
            let new = [
                z[0] * z[0],
                z[0] * z[1],
                z[0] * z[2],
                z[1] * z[1],
                z[1] * z[2],
                z[2] * z[2],
            ];
            for (sum, new) in self.squares.iter_mut().zip(new) {
                *sum = k.memory * *sum + new;
            }
            for (sum, z) in self.products.iter_mut().zip(z) {
                *sum = k.memory * *sum + y * z;
            }
            let [a, b, c] = least_squares(&self.squares, &self.products);
            self.move_towards(k, [start[0] + a, start[1] + b, start[2] + c]);
        }
        let [a, b, c] = self.coefficients;
        a * ahead.displacement_m
            + k.unit * (b * ahead.velocity_m + c * k.unit * ahead.acceleration_m)
    }

    fn unlearn(&mut self, k: &Constants) {
        (self.squares, self.products) = ([0.0; 6], [0.0; 3]);
        self.move_towards(k, [1.0, k.start[0], k.start[1]]);
    }
}

impl Ats {
    /// A bounded step of the coefficients towards the wanted ones.
    #[inline]
    fn move_towards(&mut self, k: &Constants, wanted: [f32; 3]) {
        let (tolerance, per_unit) = (k.learning.gain_tolerance, 1.0 / k.unit);
        let (longest, limit) = (k.learning.longest * per_unit, k.learning.limit * per_unit);
        // The second coefficient is half of the square of the first: its bound and its rate follow.
        let bounds = [
            (k.learning.gain_limit, 1.0 - tolerance, 1.0 + tolerance),
            (limit, 0.0, longest),
            (limit * longest, 0.0, 0.5 * longest * longest),
        ];
        for (i, (limit, low, high)) in bounds.into_iter().enumerate() {
            let step = wanted[i] - self.coefficients[i];
            self.coefficients[i] = learnt(self.coefficients[i], step, limit, low, high);
        }
    }
}

/// Solves `(S + ridge) x = p` by `L D L^T`.
#[inline]
fn least_squares(squares: &[f32; 6], p: &[f32; 3]) -> [f32; 3] {
    let [s00, s01, s02, s11, s12, s22] = *squares;
    let ridge = RIDGE * (s00 + s11 + s22);
    let per_d0 = 1.0 / (s00 + ridge);
    let (l10, l20) = (s01 * per_d0, s02 * per_d0);
    let per_d1 = 1.0 / (s11 + ridge - l10 * s01);
    let below = s12 - l20 * s01;
    let l21 = below * per_d1;
    let per_d2 = 1.0 / (s22 + ridge - l20 * s02 - l21 * below);
    let y1 = p[1] - l10 * p[0];
    let x2 = (p[2] - l20 * p[0] - l21 * y1) * per_d2;
    let x1 = y1 * per_d1 - l21 * x2;
    [p[0] * per_d0 - l10 * x1 - l20 * x2, x1, x2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::checks::{self, Axis};

    #[test]
    fn solves_a_system_of_three() {
        let s = [4.0, 1.0, -0.5, 3.0, 0.2, 2.0];
        let x = [0.5_f32, -1.0, 2.0];
        let p = [
            s[0] * x[0] + s[1] * x[1] + s[2] * x[2],
            s[1] * x[0] + s[3] * x[1] + s[4] * x[2],
            s[2] * x[0] + s[4] * x[1] + s[5] * x[2],
        ];
        for (found, x) in least_squares(&s, &p).into_iter().zip(x) {
            assert!((found - x).abs() < 2e-3, "{found} {x}");
        }
    }

    #[test]
    fn learns_a_delay_and_a_gain_that_it_was_told_wrong() {
        let unit = 1.0 / checks::OMEGA;
        // Those of half of the delay.
        let k = Constants {
            start: [4.0 / unit, 8.0 / (unit * unit)],
            unit,
            stiffness: 0.01,
            damping: 0.14,
            memory: 0.999,
            learning: checks::learning(),
        };
        let rest = checks::tracking_error::<Ats>(
            &k,
            Axis {
                delay: 8,
                gain: 0.95,
            },
        );
        assert!(rest < 2e-3, "{rest}");
    }
}
