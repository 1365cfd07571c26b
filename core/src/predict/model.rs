//! Model-based prediction: Carrion and Spencer, NSEL Report 006 (2007).
//!
//! The target one delay ahead follows from the present state by the structure's own equation of motion. With the load
//! held, `M a' + C a + K v = 0`: velocity and acceleration go on as a free vibration, and
//! `u(t + tau) = u + A v + B a` with two matrices that are worked out once. They become `tau` and `tau^2/2` where the
//! structure is slow, and follow its modes where it is not. The acceleration is the integration's, so whatever force was
//! measured is in it.
//!
//! Parameters: `delay_ms`, and the structure as declared. State 4 `N^2` bytes twice. Cost: 2 `N` products a floor.
//!
//! # When not to use it
//! If the specimen differs from what was declared: a yielding one is predicted as elastic. The change of the ground
//! motion within the delay is neglected.

use super::interface::{LastCommand, Predict, TargetMotion};
use crate::context::Context;
use crate::matrix::{self, Matrix};
use crate::refusal::Refusal;
use crate::structure::Structure;

/// Constants of the prediction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants<const N: usize> {
    /// A, control steps.
    velocity: [[f32; N]; N],
    /// B, control steps squared.
    acceleration: [[f32; N]; N],
}

impl<const N: usize> Constants<N> {
    /// For a delay of `delay_s` of model time; `step_s` is the control step in the same. `None` where the mass matrix
    /// has no inverse.
    pub fn new(
        structure: &Structure<N>,
        omega_highest: f64,
        delay_s: f64,
        step_s: f64,
    ) -> Option<Self> {
        let per_mass = matrix::inverse(&structure.mass)?;
        let damping = matrix::product(&per_mass, &structure.damping);
        let stiffness = matrix::product(&per_mass, &structure.stiffness);
        // Runge-Kutta: 0.05 of a radian of the highest mode a step is exact to f32.
        let steps = libm::ceil((omega_highest * delay_s / 0.05).clamp(16.0, 4096.0));
        let after = |velocity, acceleration| {
            let mut state = [matrix::zeros(), velocity, acceleration];
            for _ in 0..steps as usize {
                state = runge_kutta(&damping, &stiffness, &state, delay_s / steps);
            }
            state[0]
        };
        let (unit, zero) = (matrix::diagonal(&[1.0; N]), matrix::zeros());
        let single = |m: Matrix<N>, per: f64| m.map(|row| row.map(|x| (x / per) as f32));
        Some(Self {
            velocity: single(after(unit, zero), step_s),
            acceleration: single(after(zero, unit), step_s * step_s),
        })
    }

    /// The targets one delay ahead, m.
    #[inline(never)]
    pub fn ahead(&self, ahead: &[TargetMotion; N], physical: usize, command_m: &mut [f32; N]) {
        for i in 0..N.min(physical) {
            let mut sum = 0.0;
            for (j, now) in ahead.iter().enumerate() {
                sum += self.velocity[i][j] * now.velocity_m;
                sum += self.acceleration[i][j] * now.acceleration_m;
            }
            command_m[i] += sum;
        }
    }
}

/// Stateless: it has only constants.
#[derive(Clone, Debug)]
pub(crate) struct ModelPrediction;

impl<const N: usize> Predict<N> for ModelPrediction {
    type Constants = Constants<N>;

    const SEES_ALL: bool = true;

    fn design(context: &Context<'_, N>) -> Result<Constants<N>, Refusal> {
        let step_s = 1.0 / (context.rate_hz * context.time_scale);
        let of = |j: usize| {
            let delay_s = context.model_delay_s(j);
            Constants::new(context.structure, context.omega[N - 1], delay_s, step_s)
                .ok_or(Refusal::matrix("structure.mass_kg"))
        };
        let mut all = of(0)?;
        for j in 1..context.physical() {
            // The matrices are much work, and most rigs have one delay.
            if context.model_delay_s(j) != context.model_delay_s(0) {
                let own = of(j)?;
                all.velocity[j] = own.velocity[j];
                all.acceleration[j] = own.acceleration[j];
            }
        }
        Ok(all)
    }

    fn at_rest(_: &Constants<N>) -> Self {
        Self
    }

    fn command(
        &mut self,
        k: &Constants<N>,
        _: &[LastCommand; N],
        ahead: &[TargetMotion; N],
        physical: usize,
        command_m: &mut [f32; N],
    ) {
        k.ahead(ahead, physical, command_m);
    }
}

/// Displacement, velocity and acceleration, one column for each start.
type State<const N: usize> = [Matrix<N>; 3];

/// One step of the classical fourth-order method on `u' = v, v' = a, a' = -M^-1 (C a + K v)`.
fn runge_kutta<const N: usize>(
    damping: &Matrix<N>,
    stiffness: &Matrix<N>,
    state: &State<N>,
    h: f64,
) -> State<N> {
    let slope = |[_, v, a]: &State<N>| {
        let pull = matrix::sum(
            &matrix::product(damping, a),
            1.0,
            &matrix::product(stiffness, v),
        );
        [*v, *a, matrix::sum(&matrix::zeros(), -1.0, &pull)]
    };
    let on = |by: f64, slope: &State<N>| -> State<N> {
        core::array::from_fn(|i| matrix::sum(&state[i], by, &slope[i]))
    };
    let k1 = slope(state);
    let k2 = slope(&on(h / 2.0, &k1));
    let k3 = slope(&on(h / 2.0, &k2));
    let k4 = slope(&on(h, &k3));
    core::array::from_fn(|i| {
        let middle = matrix::sum(&k2[i], 1.0, &k3[i]);
        let ends = matrix::sum(&k1[i], 1.0, &k4[i]);
        matrix::sum(&state[i], h / 6.0, &matrix::sum(&ends, 2.0, &middle))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A free vibration of the second mode of two storeys, a quarter of its period ahead.
    #[test]
    fn a_free_vibration_is_predicted_exactly() {
        let s =
            Structure::<2>::shear_frame(&[1e3; 2], &[4e5, 4e5], &[0.0; 2], 2, &[0.0; 2]).unwrap();
        let omegas = s.natural_frequencies_rad_per_s().unwrap();
        let (omega, step_s) = (omegas[1], 5e-4);
        let delay_s = 1.5 / omega;
        let k = Constants::new(&s, omega, delay_s, step_s).unwrap();
        // Mode shape of the second mode: (1.618, -1); u = shape cos(omega t).
        let shape = [1.618_034, -1.0];
        let t = 0.3 / omega;
        let at = |j: usize| TargetMotion {
            displacement_m: (shape[j] * libm::cos(omega * t)) as f32,
            velocity_m: (-shape[j] * omega * step_s * libm::sin(omega * t)) as f32,
            acceleration_m: (-shape[j] * omega * omega * step_s * step_s * libm::cos(omega * t))
                as f32,
        };
        let ahead = [at(0), at(1)];
        let mut command_m = ahead.map(|a| a.displacement_m);
        k.ahead(&ahead, 2, &mut command_m);
        for j in 0..2 {
            let exact = shape[j] * libm::cos(omega * (t + delay_s));
            assert!((f64::from(command_m[j]) - exact).abs() < 2e-5, "{j}");
        }
    }
}
