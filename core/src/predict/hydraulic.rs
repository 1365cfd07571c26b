//! Inverse of a servo-hydraulic actuator whose uncertain parameters are estimated on line.
//!
//! Valve (second order), actuator (first order) with natural velocity feedback, specimen (mass, damping, stiffness) and a
//! unity feedback of the displacement have, from command to displacement, no zeros: `u = sum alpha_n d^n y/dt^n`, n to 5
//! (Silva et al., MSSP 135 (2020) 106381). So the command is worked out from the target's derivatives, taken half a control
//! step ahead because it is held for one.
//!
//! Four parameters are uncertain: stiffness of the specimen, pole of the actuator, damping and squared frequency of the
//! valve. They are estimated *forwards*: the model is driven by the command, which carries no noise, and its output is
//! compared with the reading, recursive least squares with the declared spreads as prior. The other way round (the
//! command explained by derivatives of the reading) the sensor's noise would be in the regressors.
//!
//! Parameters: `hydraulic`; left out, an actuator that is late by `delay_ms` is guessed. State 170 bytes an axis. Cost: some 350 operations.
//!
//! # When not to use it
//! It knows the structure of the actuator and that the specimen is linear. With another actuator the four parameters
//! absorb what they can; see the benchmark's rows for a specimen that yields.

use super::interface::{LastCommand, PredictAxis, TargetMotion};
use crate::config::{self, Compensation, Timing};
use crate::context::ActuatorContext;
use crate::float::{larger, smaller};
use crate::refusal::{Refusal, accept, between};

/// Uncertain parameters: stiffness, a3, b1, b2.
const P: usize = 4;

/// Largest change of a parameter, standard deviations.
const MOST: f32 = 4.0;

/// The actuator and its specimen. The unit of time is the control step, that of the coefficients `alpha` of it, too.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Parameters as declared: k, a3, b1, b2.
    pub declared: [f32; P],
    /// Their standard deviations.
    pub spread: [f32; P],
    /// a2, c and m.
    pub fixed: [f32; 3],
    /// a1 b0.
    pub gain: f32,
    /// 1/6; read from the flash it would cost the wait states.
    pub sixth: f32,
    /// 1 over what the declared coefficients have at rest: a calibrated command goes where it says.
    pub per_numerator: f32,
    /// The standard deviations times that.
    pub spread_per_numerator: [f32; P],
    /// Variance that an error of the model's output counts as, m^2: that of three times the noise. With the noise
    /// alone the estimate would follow what the model leaves out.
    pub variance_m2: f32,
}

/// A polynomial in s of fifth order.
type Polynomial = [f32; 6];

/// alpha, and its derivatives by each parameter: those by k, by a3, by b1 (without the factor s that it has) and by b2.
type Slopes = ([f32; 4], [f32; 5], [f32; 4], [f32; 4]);

impl Constants {
    /// alpha of the parameters `p`, and its derivatives by each.
    #[inline]
    fn polynomials(&self, p: &[f32; P]) -> (Polynomial, Slopes) {
        let [k, a3, b1, b2] = *p;
        let [a2, c, m] = self.fixed;
        // (m s^2 + c s + k)(s + a3) + a2 s, times (s^2 + b1 s + b2), plus a1 b0. Written out: what is 0 or 1 is not
        // multiplied with.
        let inner = [k * a3, k + c * a3 + a2, c + m * a3, m];
        let [i0, i1, i2, i3] = inner;
        let alpha = [
            i0 * b2 + self.gain,
            i0 * b1 + i1 * b2,
            i0 + i1 * b1 + i2 * b2,
            i1 + i2 * b1 + i3 * b2,
            i2 + i3 * b1,
            i3,
        ];
        let by_k = [a3 * b2, a3 * b1 + b2, a3 + b1, 1.0];
        let by_a3 = [k * b2, k * b1 + c * b2, k + c * b1 + m * b2, c + m * b1, m];
        let [sk, sa, s1, s2] = self.spread_per_numerator;
        (
            alpha.map(|x| x * self.per_numerator),
            (
                by_k.map(|x| x * sk),
                by_a3.map(|x| x * sa),
                inner.map(|x| x * s1),
                inner.map(|x| x * s2),
            ),
        )
    }
}

/// `1 / alpha(s)` by the trapezoidal rule: its output and the first five derivatives, per control step.
#[derive(Clone, Copy, Debug)]
struct Chain([f32; 6]);

impl Chain {
    #[inline]
    fn pass(&mut self, alpha: &Polynomial, per_weight: f32, input: f32) {
        // Each derivative as it would be with the highest at 0 from now on.
        let (mut rest, mut sum) = (input, self.0[5]);
        for n in (0..5).rev() {
            let here = self.0[n];
            let without = here + 0.5 * sum;
            rest -= alpha[n] * without;
            (sum, self.0[n]) = (here + without, without);
        }
        let highest = rest * per_weight;
        let mut share = highest;
        self.0[5] = highest;
        for n in (0..5).rev() {
            share *= 0.5;
            self.0[n] += share;
        }
    }

    /// Weight of the highest derivative in the rule.
    #[inline]
    fn weight(alpha: &Polynomial) -> f32 {
        let [a, b, c, d, e, f] = *alpha;
        // Powers of a half that are part of an instruction; smaller ones would be read from the flash.
        f + 0.5 * e + 0.25 * d + 0.125 * c + 0.25 * (0.25 * b) + 0.25 * (0.125 * a)
    }
}

/// The plant as declared, or one that is late by the declared delay.
fn plant(c: &Compensation, delay_ms: f64, stiffness_n_per_m: f64) -> config::Hydraulic {
    let guessed = || config::Hydraulic::of_delay(delay_ms * 1e-3, stiffness_n_per_m);
    c.hydraulic.clone().unwrap_or_else(guessed)
}

/// Fraction of what was learnt that is taken back per control step, if it has to be.
const UNLEARNS_A_STEP: f32 = 0.002;

/// One axis.
#[derive(Clone, Debug)]
pub(crate) struct Hydraulic {
    /// Estimate, standard deviations from what was declared.
    theta: [f32; P],
    /// Its covariance, which is symmetric: only the upper triangle is kept.
    covariance: [[f32; P]; P],
    model: Chain,
    sensitivity: Chain,
    /// Acceleration and its difference a control step ago.
    past: [f32; 2],
}

impl PredictAxis for Hydraulic {
    type Constants = Constants;

    const LEARNS: bool = true;

    fn check(c: &Compensation, _: &Timing) -> Result<(), Refusal> {
        let Some(h) = &c.hydraulic else {
            return Ok(());
        };
        for (name, value) in [
            ("compensation.hydraulic.a1_b0", h.a1_b0),
            ("compensation.hydraulic.b1", h.b1),
            ("compensation.hydraulic.b2", h.b2),
            (
                "compensation.hydraulic.stiffness_n_per_m",
                h.stiffness_n_per_m,
            ),
            ("compensation.hydraulic.mass_kg", h.mass_kg),
            ("compensation.hydraulic.noise_m", h.noise_m),
        ] {
            between(name, value, 0.0, 1e20, "above 0 and below 1e20")?;
        }
        for (name, value) in [
            ("compensation.hydraulic.a2", h.a2),
            ("compensation.hydraulic.a3", h.a3),
            (
                "compensation.hydraulic.damping_n_s_per_m",
                h.damping_n_s_per_m,
            ),
        ]
        .into_iter()
        .chain(h.spread.map(|s| ("compensation.hydraulic.spread", s)))
        {
            let accepted = "at least 0 and below 1e20";
            accept(name, value, (0.0..1e20).contains(&value), accepted)?;
        }
        Ok(())
    }

    fn design(context: &ActuatorContext<'_>) -> Constants {
        let stiffness_n_per_m = context.stiffness_n_per_m;
        let h = plant(context.parameters, context.delay_ms, stiffness_n_per_m);
        let step_s = 1.0 / context.rate_hz;
        // With the control step as the unit of time, every coefficient is of one size.
        let units = [1.0, step_s, step_s, step_s * step_s];
        let scaled = |values: [f64; P]| core::array::from_fn(|i| (values[i] * units[i]) as f32);
        let gain = h.a1_b0 * step_s * step_s * step_s;
        let static_part = h.stiffness_n_per_m * h.a3 * h.b2 * step_s * step_s * step_s + gain;
        Constants {
            declared: scaled([h.stiffness_n_per_m, h.a3, h.b1, h.b2]),
            spread: scaled(h.spread),
            fixed: [
                h.a2,
                h.damping_n_s_per_m / step_s,
                h.mass_kg / (step_s * step_s),
            ]
            .map(|x| x as f32),
            gain: gain as f32,
            sixth: 1.0 / 6.0,
            per_numerator: (1.0 / static_part) as f32,
            spread_per_numerator: scaled(h.spread).map(|s| s * (1.0 / static_part) as f32),
            variance_m2: (9.0 * h.noise_m * h.noise_m) as f32,
        }
    }

    fn at_rest(_: &Constants) -> Self {
        let mut covariance = [[0.0; P]; P];
        for (i, row) in covariance.iter_mut().enumerate() {
            row[i] = 1.0;
        }
        Self {
            theta: [0.0; P],
            covariance,
            model: Chain([0.0; 6]),
            sensitivity: Chain([0.0; 6]),
            past: [0.0; 2],
        }
    }

    #[inline(never)] // Inside of the loop over the axes all constants would be put on the stack before it.
    fn command(&mut self, k: &Constants, followed: &LastCommand, ahead: &TargetMotion) -> f32 {
        let mut p = k.declared;
        for i in 0..P {
            p[i] += k.spread[i] * self.theta[i];
        }
        let (alpha, (by_k, by_a3, by_b1, by_b2)) = k.polynomials(&p);
        let per_weight = 1.0 / Chain::weight(&alpha);
        self.model.pass(&alpha, per_weight, followed.sent_m);
        // The command was held from half a step before to half a step behind what the rule takes for its time.
        let [y, y1, ..] = self.model.0;
        let estimate_m = y + 0.5 * y1;
        self.sensitivity.pass(&alpha, per_weight, estimate_m);
        if followed.learn {
            let of = &self.sensitivity.0;
            let phi = [
                -along(&by_k, of),
                -along(&by_a3, of),
                -along(&by_b1, &of[1..]),
                -along(&by_b2, of),
            ];
            self.learn(k, &phi, followed.measured_m - estimate_m);
        }
        inverse(&alpha, k.sixth, ahead, &mut self.past)
    }

    fn unlearn(&mut self, _: &Constants) {
        for theta in &mut self.theta {
            *theta *= 1.0 - UNLEARNS_A_STEP;
        }
    }
}

impl Hydraulic {
    /// The covariance times `phi`.
    #[inline]
    fn reach(&self, phi: &[f32; P]) -> [f32; P] {
        let [[a, b, c, d], [_, e, f, g], [_, _, h, i], [.., j]] = self.covariance;
        let rows = [[a, b, c, d], [b, e, f, g], [c, f, h, i], [d, g, i, j]];
        rows.map(|row| along(phi, &row))
    }

    /// A step of recursive least squares.
    #[inline]
    fn learn(&mut self, k: &Constants, phi: &[f32; P], error_m: f32) {
        let reach = self.reach(phi);
        let products = phi.iter().zip(&reach);
        let size = products.fold(k.variance_m2, |size, (p, r)| size + p * r);
        let per_size = 1.0 / size;
        if !(error_m * per_size).is_finite() || !(per_size > 0.0) {
            return;
        }
        for i in 0..P {
            let moved = self.theta[i] + reach[i] * per_size * error_m;
            self.theta[i] = smaller(larger(moved, -MOST), MOST);
            for j in i..P {
                let left = self.covariance[i][j] - reach[i] * reach[j] * per_size;
                self.covariance[i][j] = left;
            }
        }
    }
}

/// Sum of the products of two rows, over the shorter.
#[inline]
fn along(row: &[f32], other: &[f32]) -> f32 {
    row.iter().zip(other).map(|(a, b)| a * b).sum()
}

/// `sum alpha_n d^n u/dt^n` half a control step before the end of the one that begins; third and fourth derivative are
/// differences of the acceleration, the fifth is left out.
#[inline]
fn inverse(alpha: &Polynomial, sixth: f32, ahead: &TargetMotion, past: &mut [f32; 2]) -> f32 {
    let a = ahead.acceleration_m;
    let first = a - past[0];
    let second = first - past[1];
    *past = [a, first];
    // Half a step before now the first difference is the jerk there.
    let (jerk, snap) = (first, second);
    let a_half = a - 0.5 * jerk;
    let v_half = ahead.velocity_m - 0.5 * (a - 0.25 * jerk);
    let u_half = ahead.displacement_m - 0.5 * (ahead.velocity_m - 0.25 * (a - jerk * sixth));
    alpha[0] * u_half + alpha[1] * v_half + alpha[2] * a_half + alpha[3] * jerk + alpha[4] * snap
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The benchmark problem's nominal plant at 4096 Hz, and what it is declared to be.
    fn constants() -> Constants {
        let t = 1.0 / 4096.0_f64;
        let (k, gain) = (1.19e6, 2.1283e13 * t * t * t);
        let spread = [5e4, 1.3 * t, 3.3 * t, 3.3e3 * t * t].map(|x| x as f32);
        let per_numerator = (1.0 / (k * 3.3 * 9.9976e4 * t * t * t + gain)) as f32;
        Constants {
            declared: [k, 3.3 * t, 425.0 * t, 9.9976e4 * t * t].map(|x| x as f32),
            spread,
            fixed: [4.2297e6, 114.2 / t, 29.13 / (t * t)].map(|x| x as f32),
            gain: gain as f32,
            sixth: 1.0 / 6.0,
            per_numerator,
            spread_per_numerator: spread.map(|s| s * per_numerator),
            variance_m2: 2.2e-9,
        }
    }

    /// Tracking error, relative, of a motion of 4 and 9 Hz on a plant whose parameters are off by `theta` standard
    /// deviations, in f64 with ten substeps; and what was learnt.
    fn track(k: &Constants, theta: [f64; P], learn: bool) -> (f64, [f32; P]) {
        let mut p = k.declared;
        for i in 0..P {
            p[i] += k.spread[i] * theta[i] as f32;
        }
        let alpha = k.polynomials(&p).0.map(f64::from);
        let mut axis = Hydraulic::at_rest(k);
        let mut followed = LastCommand {
            target_m: 0.0,
            sent_m: 0.0,
            measured_m: 0.0,
            learn,
        };
        let mut w = [0.0_f64; 5];
        let (mut worst, mut peak) = (0.0_f64, 0.0_f64);
        let target = |i: f64| {
            let wave = |hz: f64, size: f64| {
                let omega = core::f64::consts::TAU * hz / 4096.0;
                let (sin, cos) = (libm::sin(omega * i), libm::cos(omega * i));
                [size * sin, size * omega * cos, -size * omega * omega * sin]
            };
            let (slow, fast) = (wave(4.0, 3e-3), wave(9.0, 5e-4));
            let grown = (i / 4096.0).min(1.0);
            core::array::from_fn::<f64, 3, _>(|d| grown * (slow[d] + fast[d]))
        };
        for i in 0..40_000 {
            let [u, v, a] = target(f64::from(i + 1)).map(|x| x as f32);
            let ahead = TargetMotion {
                displacement_m: u,
                velocity_m: v,
                acceleration_m: a,
            };
            let sent = axis.command(k, &followed, &ahead);
            // The plant under a held command; classical Runge-Kutta.
            let h = 0.1;
            let slope = |w: [f64; 5]| {
                let sum: f64 = (0..5).map(|n| alpha[n] * w[n]).sum();
                [w[1], w[2], w[3], w[4], (f64::from(sent) - sum) / alpha[5]]
            };
            for _ in 0..10 {
                let on = |w: [f64; 5], k: [f64; 5], h: f64| -> [f64; 5] {
                    core::array::from_fn(|n| w[n] + h * k[n])
                };
                let k1 = slope(w);
                let k2 = slope(on(w, k1, 0.5 * h));
                let k3 = slope(on(w, k2, 0.5 * h));
                let k4 = slope(on(w, k3, h));
                for n in 0..5 {
                    w[n] += h / 6.0 * (k1[n] + 2.0 * (k2[n] + k3[n]) + k4[n]);
                }
            }
            followed = LastCommand {
                target_m: u,
                sent_m: sent,
                measured_m: w[0] as f32,
                learn,
            };
            if i > 20_000 {
                worst = worst.max((w[0] - f64::from(u)).abs());
                peak = peak.max(f64::from(u).abs());
            }
        }
        (worst / peak, axis.theta)
    }

    #[test]
    fn the_inverse_of_the_declared_plant_is_exact() {
        let (error, _) = track(&constants(), [0.0; P], false);
        assert!(error < 1e-3, "{error}");
    }

    #[test]
    fn learns_a_plant_that_is_two_standard_deviations_off() {
        let k = constants();
        let theta = [2.0, -1.5, 0.0, 2.0];
        let (told, _) = track(&k, theta, false);
        let (learnt, found) = track(&k, theta, true);
        assert!(told > 0.05 && learnt < 0.02 * told, "{learnt} of {told}");
        // What the motion cannot tell apart stays near the prior; the valve's frequency it can.
        assert!((found[3] - 2.0).abs() < 0.3, "{found:?}");
    }

    #[test]
    fn the_derivatives_of_the_polynomials_are_those_of_differences() {
        let k = constants();
        let (alpha, ([k0, k1, k2, k3], [a0, a1, a2, a3, a4], b1, b2)) = k.polynomials(&k.declared);
        let by = [
            [k0, k1, k2, k3, 0.0, 0.0],
            [a0, a1, a2, a3, a4, 0.0],
            [0.0, b1[0], b1[1], b1[2], b1[3], 0.0],
            [b2[0], b2[1], b2[2], b2[3], 0.0, 0.0],
        ];
        for i in 0..P {
            let mut p = k.declared;
            p[i] += k.spread[i];
            let (moved, _) = k.polynomials(&p);
            for n in 0..6 {
                let difference = moved[n] - alpha[n];
                assert!(
                    (difference - by[i][n]).abs() <= 2e-5 * alpha[n].abs() + 1e-9,
                    "{i} {n}"
                );
            }
        }
    }

    #[test]
    fn a_reading_that_is_none_teaches_nothing() {
        let k = constants();
        let mut axis = Hydraulic::at_rest(&k);
        axis.learn(&k, &[1e-4; P], 1e-4);
        let before = axis.theta;
        axis.learn(&k, &[1e-4; P], f32::NAN);
        axis.learn(&k, &[f32::INFINITY; P], 1e-4);
        assert_eq!(axis.theta, before);
        assert!(before.iter().all(|t| t.is_finite() && *t != 0.0));
    }
}
