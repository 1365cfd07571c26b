//! Stage 1: displacement and velocity of one actuator, with the sent command as known input.
//!
//! The model carries the motion, so the filter is smooth without phase lag. Gains are steady and computed at
//! configuration, from the discrete Riccati equation.

use super::actuator_model::{Lag, multiply};
use crate::config::Estimation;
use crate::delay_line::{Delay, DelayLine};
use crate::refusal::Refusal;

/// Constants of stage 1.
#[derive(Clone, Copy, Debug)]
pub struct KalmanGains {
    delay: Delay,
    transition: [[f32; 2]; 2],
    input: [f32; 2],
    gain: [f32; 2],
    /// 1 / expected variance of the innovation, 1/m^2.
    certainty: f32,
}

type Matrix2 = [[f64; 2]; 2];

impl KalmanGains {
    /// Steady gains for a control step of `step_s`, of the actuator with this number from 0.
    ///
    /// # Errors
    /// A Riccati equation without a finite solution.
    #[inline(never)] // Inlined, it would be in an image once per number of actuators.
    pub fn new(e: &Estimation, step_s: f64, actuator: usize) -> Result<Self, Refusal> {
        let lag_s = e.lag_ms.at(actuator) * 1e-3;
        let model = Lag::new(lag_s, e.lag_damping_ratio, step_s);
        // White acceleration, in the filter's unit of metres per step.
        let process = e.process_m_per_s2 * step_s * step_s;
        let q = process * process;
        let noise = e.displacement_noise_m * e.displacement_noise_m;
        let predicted = riccati(
            &model.transition,
            &[[q / 4.0, q / 2.0], [q / 2.0, q]],
            noise,
        );
        let expected = predicted[0][0] + noise;
        if !(expected.is_finite() && expected > 0.0) {
            return Err(Refusal {
                name: "estimation.process_m_per_s2",
                value: e.process_m_per_s2,
                accepted: "values for which the Kalman filter has a finite steady gain",
            });
        }
        Ok(Self {
            delay: Delay::new(e.delay_ms.at(actuator) * 1e-3 / step_s),
            transition: model.transition.map(|row| row.map(|x| x as f32)),
            input: model.input.map(|x| x as f32),
            gain: [
                (predicted[0][0] / expected) as f32,
                (predicted[1][0] / expected) as f32,
            ],
            certainty: (1.0 / expected) as f32,
        })
    }
}

/// Steady predicted covariance of `x' = F x + w` observed through its first state, by structured doubling (Anderson
/// 1978): 30 doublings reach the steady state of 2^30 steps.
fn riccati(f: &Matrix2, q: &Matrix2, noise: f64) -> Matrix2 {
    let mut a = crate::matrix::transpose(f);
    let mut g = [[1.0 / noise, 0.0], [0.0, 0.0]];
    let mut h = *q;
    for _ in 0..30 {
        // W = (I + G H)^-1.
        let gh = multiply(&g, &h);
        let (w, x, y, z) = (1.0 + gh[0][0], gh[0][1], gh[1][0], 1.0 + gh[1][1]);
        let det = w * z - x * y;
        let inverse = [[z / det, -x / det], [-y / det, w / det]];
        let aw = multiply(&a, &inverse);
        let at = crate::matrix::transpose(&a);
        let grown = multiply(&multiply(&aw, &g), &at);
        let hw = multiply(&h, &inverse);
        let shrunk = multiply(&multiply(&at, &hw), &a);
        a = multiply(&aw, &a);
        for i in 0..2 {
            for j in 0..2 {
                g[i][j] += grown[i][j];
                h[i][j] += shrunk[i][j];
            }
        }
    }
    h
}

/// State of stage 1.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct Kalman {
    displacement_m: f32,
    /// Metres per control step.
    velocity_m: f32,
    command: DelayLine,
}

impl Kalman {
    /// At rest at `position_m`.
    pub const fn at_rest(position_m: f32) -> Self {
        Self {
            command: DelayLine::filled(position_m),
            displacement_m: position_m,
            velocity_m: 0.0,
        }
    }

    /// Estimated displacement, m.
    #[inline]
    pub fn displacement_m(&self) -> f32 {
        self.displacement_m
    }

    /// One control step; returns the squared innovation relative to its expected variance.
    #[inline]
    pub fn update(&mut self, k: &KalmanGains, sent_m: f32, measured_m: f32) -> f32 {
        let u = self.command.pass(k.delay, sent_m);
        let (x, v) = (self.displacement_m, self.velocity_m);
        let predicted = k.transition[0][0] * x + k.transition[0][1] * v + k.input[0] * u;
        let velocity = k.transition[1][0] * x + k.transition[1][1] * v + k.input[1] * u;
        let innovation = measured_m - predicted;
        self.displacement_m = predicted + k.gain[0] * innovation;
        self.velocity_m = velocity + k.gain[1] * innovation;
        innovation * innovation * k.certainty
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_riccati_solution_is_a_fixed_point() {
        let f = Lag::new(0.03, 0.7, 0.0005).transition;
        let q = [[2.5e-7, 5e-7], [5e-7, 1e-6]];
        let (noise, p) = (1e-2, riccati(&f, &[[2.5e-7, 5e-7], [5e-7, 1e-6]], 1e-2));
        let gain = [p[0][0] / (p[0][0] + noise), p[1][0] / (p[0][0] + noise)];
        let mut filtered = p;
        for i in 0..2 {
            for j in 0..2 {
                filtered[i][j] -= gain[i] * p[0][j];
            }
        }
        let next = multiply(&multiply(&f, &filtered), &crate::matrix::transpose(&f));
        for i in 0..2 {
            for j in 0..2 {
                assert!((next[i][j] + q[i][j] - p[i][j]).abs() < 1e-9 * p[i][i].max(p[j][j]));
            }
        }
    }

    #[test]
    fn a_matching_model_has_no_lag_and_an_innovation_of_one() {
        let e = Estimation {
            delay_ms: 2.0.into(),
            lag_ms: 4.0.into(),
            displacement_noise_m: 1e-3,
            ..Estimation::default()
        };
        let k = KalmanGains::new(&e, 5e-4, 0).unwrap();
        let model = Lag::new(4e-3, e.lag_damping_ratio, 5e-4);
        let (mut line, mut x) = (DelayLine::<16>::filled(0.0), [0.0_f64; 2]);
        let mut filter = Kalman::at_rest(0.0);
        let (mut seed, mut worst, mut squares) = (1_u32, 0.0_f64, 0.0);
        for i in 0..20_000 {
            let u = 0.05 * libm::sinf(i as f32 * 0.01);
            let d = f64::from(line.pass(Delay::new(4.0), u));
            let f = model.transition;
            x = [
                f[0][0] * x[0] + f[0][1] * x[1] + model.input[0] * d,
                f[1][0] * x[0] + f[1][1] * x[1] + model.input[1] * d,
            ];
            // Sum of 12 uniforms minus 6: Gaussian enough for a variance.
            let mut noise = -6.0;
            for _ in 0..12 {
                seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                noise += f64::from(seed >> 8) / 16_777_216.0;
            }
            squares += f64::from(filter.update(&k, u, (x[0] + 1e-3 * noise) as f32));
            if i > 1000 {
                worst = worst.max((f64::from(filter.displacement_m()) - x[0]).abs());
            }
        }
        assert!(worst < 1e-4, "error {worst} m under noise of 1e-3 m");
        assert!(
            (squares / 20_000.0 - 1.0).abs() < 0.05,
            "innovation {squares}"
        );
    }
}
