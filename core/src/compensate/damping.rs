//! The paper's variable damping: what takes the energy error of the actuator out again.
//!
//! A viscous damping that dissipates, in each step, what the actuator's error put in. Eq 14:
//! `C_cor = -2 E / ((v_{i-1} + v^_i)(u_i - u_{i-1}))`. Since `v_{i-1} + v^_i = 2 (u_i - u_{i-1}) / dt` exactly for
//! explicit Newmark with Eq 16, this is `-E dt / du^2`, and Eq 20 is the same times the gain of Eq 19 (the plus sign
//! printed in its denominator is a misprint: with it, it does nothing).
//!
//! # Limitations
//! With more than one actuator the damping is diagonal, each axis from its own energy error. The total energy is
//! right; the form is ill-conditioned where one floor stands still while others move, which is what the hold rule and
//! the clamp are for.

use super::Correction;
use super::sech_gain::sech_gain;
use crate::config::{Method, Secant};
use crate::energy::Windowed;
use crate::order::{larger, smaller};

/// Constants of the variable damping, worked out once.
#[derive(Clone, Debug)]
pub struct Constants<const N: usize> {
    /// Which equation.
    pub method: Method,
    /// Which increment the energy is divided by.
    pub secant: Secant,
    /// Exponent of the sech gain.
    pub gamma: f32,
    /// Fundamental natural frequency times the integration step.
    pub omega_dt: f32,
    /// Time of the window, s of model time.
    pub window_s: f32,
    /// Largest C_cor, N s/m, by axis.
    pub largest: [f32; N],
    /// Smallest C_cor, N s/m, by axis: the clamp below, or what the effective-mass guard still allows.
    pub smallest: [f32; N],
    /// Share of the running peak of the increment below which the last value is held.
    pub hold_share: f32,
    /// What the running peak keeps from one integration step to the next.
    pub peak_memory: f32,
}

/// How the structure moves, as the compensation sees it.
#[derive(Clone, Copy, Debug)]
pub struct Motion<const N: usize> {
    /// u_i, m.
    pub displacement_m: [f32; N],
    /// dt v_{i-1}, m.
    pub velocity_dt_m: [f32; N],
    /// dt v^_i, Eq 16, m.
    pub predictor_velocity_dt_m: [f32; N],
}

/// The variable damping and its memory.
#[derive(Clone, Debug)]
pub struct VariableDamping<const N: usize> {
    last: [f32; N],
    peak_m: [f32; N],
}

impl<const N: usize> VariableDamping<N> {
    /// With no damping yet.
    pub const fn at_rest() -> Self {
        Self {
            last: [0.0; N],
            peak_m: [0.0; N],
        }
    }

    /// C_cor for this step, from Eq 12 over the window and the motion.
    #[inline]
    pub fn update(
        &mut self,
        k: &Constants<N>,
        energy: &Windowed<N>,
        motion: &Motion<N>,
    ) -> Correction<N> {
        let mut out = Correction::NONE;
        for j in 0..N {
            let du = energy.increment_m[j];
            let velocity = motion.velocity_dt_m[j];
            let gain = match k.method {
                Method::Paper => sech_gain(k.omega_dt, motion.displacement_m[j], velocity, k.gamma),
                _ => 1.0,
            };
            let guarded = k.method != Method::Eq14Unguarded;
            // The peak fades within a natural period: in the quiet end of a test a peak of its strong part would hold
            // whatever C_cor happened to be last, for ever.
            self.peak_m[j] = larger(k.peak_memory * self.peak_m[j], du.abs());
            let reversal = velocity * motion.predictor_velocity_dt_m[j] < 0.0;
            // The sign rule alone leaves 0/0 beside a reversal, which f32 cannot resolve.
            let small = guarded && du.abs() <= k.hold_share * self.peak_m[j];
            let across = match k.secant {
                Secant::Command => du,
                Secant::Measured => energy.moved_m[j],
            };
            let raw = -energy.energy_j[j] * gain * k.window_s / (du * across);
            let apart = du * across < 0.0;
            let damping = if reversal || small || apart || !raw.is_finite() {
                out.held = true;
                self.last[j]
            } else if guarded {
                let bounded = larger(smaller(raw, k.largest[j]), k.smallest[j]);
                out.clamped |= bounded != raw;
                bounded
            } else {
                raw
            };
            self.last[j] = damping;
            out.damping[j] = damping;
            out.gain[j] = gain;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn constants(method: Method) -> Constants<1> {
        Constants {
            method,
            secant: Secant::Command,
            gamma: 0.05,
            omega_dt: 0.006,
            window_s: 5e-4,
            largest: [1264.0],
            smallest: [0.0],
            hold_share: 0.05,
            peak_memory: 0.999,
        }
    }

    fn moving(du: f32, velocity: f32, predictor: f32) -> Motion<1> {
        Motion {
            displacement_m: [10.0 * du],
            velocity_dt_m: [velocity],
            predictor_velocity_dt_m: [predictor],
        }
    }

    #[test]
    fn a_pure_lag_asks_for_stiffness_times_delay() {
        // du = 1 mm a step, error = -8 steps of it: E = -8e-3 * 158 per step, C = K tau.
        let (du, k) = (1e-3_f32, 158e3_f32);
        let energy = Windowed {
            energy_j: [-8.0 * du * k * du],
            increment_m: [du],
            moved_m: [du],
        };
        let mut c = VariableDamping::at_rest();
        let out = c.update(&constants(Method::Eq14), &energy, &moving(du, du, du));
        assert!((out.damping[0] / (k * 0.004) - 1.0).abs() < 1e-5);
        assert!(!out.held && !out.clamped);
    }

    #[test]
    fn holds_at_a_reversal_and_at_a_small_increment_and_clamps() {
        let k = constants(Method::Eq14);
        let mut c = VariableDamping::at_rest();
        let energy = |e: f32, du: f32| Windowed {
            energy_j: [e],
            increment_m: [du],
            moved_m: [du],
        };
        let first = c
            .update(&k, &energy(-1e-3, 1e-3), &moving(1e-3, 1e-3, 1e-3))
            .damping[0];
        let reversal = c.update(&k, &energy(-9.0, 1e-3), &moving(1e-3, 1e-3, -1e-3));
        assert!(reversal.held && reversal.damping[0] == first);
        let small = c.update(&k, &energy(-9.0, 1e-5), &moving(1e-5, 1e-5, 1e-5));
        assert!(small.held && small.damping[0] == first);
        let large = c.update(&k, &energy(-9.0, 1e-3), &moving(1e-3, 1e-3, 1e-3));
        assert!(large.clamped && large.damping[0] == 1264.0);
        let negative = c.update(&k, &energy(9.0, 1e-3), &moving(1e-3, 1e-3, 1e-3));
        assert!(negative.clamped && negative.damping[0] == 0.0);
    }

    #[test]
    fn rest_divides_nothing() {
        let energy = Windowed {
            energy_j: [0.0],
            increment_m: [0.0],
            moved_m: [0.0],
        };
        for method in [Method::Eq14Unguarded, Method::Eq14, Method::Paper] {
            let out = VariableDamping::at_rest().update(
                &constants(method),
                &energy,
                &moving(0.0, 0.0, 0.0),
            );
            assert_eq!(out.damping, [0.0], "{}", method.name());
        }
    }
}
