//! The paper's variable damping, which removes the actuator's energy error again.
//!
//! A viscous damping that dissipates, in each step, what the actuator's error put in. Eq 14:
//! `C_cor = -2 E / ((v_{i-1} + v^_i)(u_i - u_{i-1}))`. Since `v_{i-1} + v^_i = 2 (u_i - u_{i-1}) / dt` exactly for
//! explicit Newmark with Eq 16, this is `-E dt / du^2`, and Eq 20 is the same times the gain of Eq 19 (the plus sign
//! printed in its denominator is a misprint: with it, it does nothing).
//!
//! Parameters: `secant`, `gamma`, `window_steps`, `delay_ms`, `clamp`, `clamp_below`, `least_mass`, `hold_share`.
//!
//! # When not to use it
//! With more than one actuator the damping is diagonal, each axis from its own energy error. The total energy is
//! right, but the form is ill-conditioned if one floor stands still while others move. The hold rule and the clamp
//! limit that; the tangent force is better there. Its own error is a stiffness `omega^2 tau^2` too high: 1 % of
//! the response to some 4 ms at half a second of period, useless beyond `omega tau` of .2.

use super::interface::{Correction, ForceLaw, LawInput, LawOutput};
use super::sech_gain::SechGain;
use crate::config::{Compensation, Secant};
use crate::context::Context;
use crate::float::{larger, smaller, unlikely};
use crate::refusal::{Refusal, accept, between};
use crate::structure::actuated;
use core::marker::PhantomData;

/// The equation used, and its guards.
pub(crate) trait Form: Clone + core::fmt::Debug {
    /// Hold at small increments, clamp, effective mass.
    const GUARDED: bool;
    /// The sech gain of Eq 19.
    const GAINED: bool;
}

/// Eq 14 as published.
#[derive(Clone, Debug)]
pub(crate) struct Unguarded;

/// Eq 14 with the guards.
#[derive(Clone, Debug)]
pub(crate) struct Guarded;

/// Eq 20 with the guards.
#[derive(Clone, Debug)]
pub(crate) struct Gained;

impl Form for Unguarded {
    const GUARDED: bool = false;
    const GAINED: bool = false;
}

impl Form for Guarded {
    const GUARDED: bool = true;
    const GAINED: bool = false;
}

impl Form for Gained {
    const GUARDED: bool = true;
    const GAINED: bool = true;
}

/// Constants of the variable damping, worked out once.
#[derive(Clone, Debug)]
pub(crate) struct Constants<const N: usize> {
    /// Which increment the energy is divided by.
    secant: Secant,
    /// The gain of Eq 19.
    gain: SechGain,
    /// Time of the window, s of model time.
    window_s: f32,
    /// Largest C_cor, N s/m, by axis.
    largest: [f32; N],
    /// Smallest C_cor, N s/m, by axis: the clamp below, or what the effective-mass guard still allows.
    smallest: [f32; N],
    /// Fraction of the running peak increment below which the last value is held.
    hold_share: f32,
    /// Decay factor of the running peak per integration step.
    peak_memory: f32,
    /// Number of axes in the laboratory.
    physical: usize,
}

/// Least and largest C_cor in units of `K tau`.
fn clamps(c: &Compensation, physical: usize) -> [f64; 2] {
    // A single floor's share of a frame's damping may be negative.
    let below = if physical > 1 { -c.clamp } else { 0.0 };
    [c.clamp_below.unwrap_or(below), c.clamp]
}

/// The variable damping and its state.
#[derive(Clone, Debug)]
pub(crate) struct VariableDamping<const N: usize, F> {
    last: [f32; N],
    peak_m: [f32; N],
    form: PhantomData<F>,
}

impl<const N: usize, F: Form> ForceLaw<N> for VariableDamping<N, F> {
    type Constants = Constants<N>;

    fn check(c: &Compensation) -> Result<(), Refusal> {
        accept(
            "compensation.gamma",
            c.gamma,
            c.gamma > 0.0 && c.gamma <= 1.0,
            "above 0 and at most 1",
        )?;
        between(
            "compensation.clamp",
            c.clamp,
            0.0,
            1e3,
            "above 0 and below 1000",
        )?;
        if let Some(below) = c.clamp_below {
            accept(
                "compensation.clamp_below",
                below,
                below <= 0.0 && below > -1e3,
                "above -1000 and at most 0",
            )?;
        }
        between(
            "compensation.least_mass",
            c.least_mass,
            0.0,
            1.0,
            "above 0 and below 1",
        )
    }

    fn design(context: &Context<'_, N>) -> Constants<N> {
        let c = context.parameters;
        let dt_s = context.model_step_s;
        let delay_stiffness: [f64; N] =
            core::array::from_fn(|j| context.specimen_n_per_m[j][j] * context.model_delay_s(j));
        let [below, above] = clamps(c, context.physical());
        Constants {
            secant: c.secant,
            gain: SechGain::new((context.omega[0] * dt_s) as f32, c.gamma as f32),
            window_s: (f64::from(c.window_steps) * dt_s) as f32,
            largest: delay_stiffness.map(|k| (above * k) as f32),
            smallest: core::array::from_fn(|j| {
                let guard = -2.0 * (1.0 - c.least_mass) * context.structure.mass[j][j] / dt_s;
                (below * delay_stiffness[j]).max(guard) as f32
            }),
            hold_share: c.hold_share as f32,
            peak_memory: context.peak_memory(),
            physical: context.physical(),
        }
    }

    fn at_rest(_: &Constants<N>) -> Self {
        Self {
            last: [0.0; N],
            peak_m: [0.0; N],
            form: PhantomData,
        }
    }

    /// C_cor for this step, from Eq 12 over the window and the motion.
    #[inline]
    fn act(
        &mut self,
        k: &Constants<N>,
        reached: &LawInput<'_, N>,
        shown: &mut Correction<N>,
    ) -> LawOutput<N> {
        let (now, energy) = (reached.now, reached.energy);
        let mut acting = [0.0; N];
        let (mut held, mut clamped) = (false, false);
        for j in 0..actuated::<N>(k.physical) {
            let du = energy.increment_m[j];
            let velocity = reached.velocity_dt_m[j];
            let gain = if F::GAINED {
                k.gain.at(now.command_m[j], velocity)
            } else {
                1.0
            };
            // The peak fades within a natural period: in the quiet end of a test a peak of its strong part would hold
            // whatever C_cor happened to be last, for ever.
            self.peak_m[j] = larger(k.peak_memory * self.peak_m[j], du.abs());
            let reversal = velocity * reached.predictor_velocity_dt_m[j] < 0.0;
            // The sign rule alone leaves 0/0 beside a reversal, which f32 cannot resolve.
            let small = F::GUARDED && du.abs() <= k.hold_share * self.peak_m[j];
            let across = match k.secant {
                Secant::Command => du,
                Secant::Measured => energy.moved_m[j],
            };
            let raw = -energy.energy_j[j] * gain * k.window_s / (du * across);
            let apart = du * across < 0.0;
            let damping = if reversal || small || apart || !raw.is_finite() {
                held = true;
                unlikely(self.last[j])
            } else if F::GUARDED {
                let bounded = larger(smaller(raw, k.largest[j]), k.smallest[j]);
                clamped |= bounded != raw;
                bounded
            } else {
                raw
            };
            self.last[j] = damping;
            acting[j] = damping;
            shown.damping[j] = damping;
            shown.gain[j] = gain;
        }
        (shown.held, shown.clamped) = (held, clamped);
        LawOutput {
            force_n: now.force_n,
            damping: acting,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::energy::{Observation, Windowed};

    const CONSTANTS: Constants<1> = Constants {
        secant: Secant::Command,
        gain: SechGain::new(0.006, 0.05),
        window_s: 5e-4,
        largest: [1264.0],
        smallest: [0.0],
        hold_share: 0.05,
        peak_memory: 0.999,
        physical: 1,
    };

    /// One step with the energy error `energy_j` over the increment `du`; velocity and predictor velocity are given.
    fn act<F: Form>(
        c: &mut VariableDamping<1, F>,
        energy_j: f32,
        du: f32,
        [velocity, predictor]: [f32; 2],
    ) -> Correction<1> {
        let reached = LawInput {
            now: &Observation {
                command_m: [10.0 * du],
                increment_m: [du],
                displacement_m: [10.0 * du],
                force_n: [0.0],
            },
            energy: &Windowed {
                energy_j: [energy_j],
                increment_m: [du],
                moved_m: [du],
            },
            velocity_dt_m: [velocity],
            predictor_velocity_dt_m: [predictor],
        };
        let mut shown = Correction::NONE;
        let acting = c.act(&CONSTANTS, &reached, &mut shown);
        assert_eq!(acting.damping, shown.damping);
        shown
    }

    #[test]
    fn a_pure_lag_asks_for_stiffness_times_delay() {
        // du = 1 mm a step, error = -8 steps of it: E = -8e-3 * 158 per step, C = K tau.
        let (du, k) = (1e-3_f32, 158e3_f32);
        let mut c = VariableDamping::<1, Guarded>::at_rest(&CONSTANTS);
        let out = act(&mut c, -8.0 * du * k * du, du, [du, du]);
        assert!((out.damping[0] / (k * 0.004) - 1.0).abs() < 1e-5);
        assert!(!out.held && !out.clamped);
    }

    #[test]
    fn holds_at_a_reversal_and_at_a_small_increment_and_clamps() {
        let mut c = VariableDamping::<1, Guarded>::at_rest(&CONSTANTS);
        let first = act(&mut c, -1e-3, 1e-3, [1e-3, 1e-3]).damping[0];
        let reversal = act(&mut c, -9.0, 1e-3, [1e-3, -1e-3]);
        assert!(reversal.held && reversal.damping[0] == first);
        let small = act(&mut c, -9.0, 1e-5, [1e-5, 1e-5]);
        assert!(small.held && small.damping[0] == first);
        let large = act(&mut c, -9.0, 1e-3, [1e-3, 1e-3]);
        assert!(large.clamped && large.damping[0] == 1264.0);
        let negative = act(&mut c, 9.0, 1e-3, [1e-3, 1e-3]);
        assert!(negative.clamped && negative.damping[0] == 0.0);
    }

    #[test]
    fn rest_divides_nothing() {
        fn at_rest<F: Form>() {
            let mut c = VariableDamping::<1, F>::at_rest(&CONSTANTS);
            assert_eq!(act(&mut c, 0.0, 0.0, [0.0, 0.0]).damping, [0.0]);
        }
        at_rest::<Unguarded>();
        at_rest::<Guarded>();
        at_rest::<Gained>();
    }
}
