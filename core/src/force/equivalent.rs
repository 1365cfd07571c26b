//! A force correction as the damping that it amounts to, for the paper's plot and the watch for locked structures.

use super::Correction;
use crate::context::Context;
use crate::energy::Observation;
use crate::float::larger;

/// Constants of the report.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Integration step, s of model time.
    pub dt_s: f32,
    /// Share of the running peak of the increment below which the last value stays.
    pub hold_share: f32,
    /// What the running peak keeps from one integration step to the next.
    pub peak_memory: f32,
}

impl Constants {
    /// For a test.
    pub fn design<const N: usize>(context: &Context<'_, N>) -> Self {
        Self {
            dt_s: context.model_step_s as f32,
            hold_share: context.parameters.hold_share as f32,
            peak_memory: context.peak_memory(),
        }
    }
}

/// `F_cor dt / du`, held where du says nothing.
#[derive(Clone, Debug)]
pub(crate) struct EquivalentDamping<const N: usize> {
    last: [f32; N],
    peak_m: [f32; N],
}

impl<const N: usize> EquivalentDamping<N> {
    /// Nothing yet.
    pub const fn at_rest() -> Self {
        Self {
            last: [0.0; N],
            peak_m: [0.0; N],
        }
    }

    /// What the corrected force amounts to.
    #[inline]
    pub fn of(
        &mut self,
        k: &Constants,
        now: &Observation<N>,
        corrected_n: &[f32; N],
    ) -> Correction<N> {
        let mut out = Correction::NONE;
        for j in 0..N {
            let du = now.increment_m[j];
            self.peak_m[j] = larger(k.peak_memory * self.peak_m[j], du.abs());
            let damping = (corrected_n[j] - now.force_n[j]) * k.dt_s / du;
            if du.abs() > k.hold_share * self.peak_m[j] && damping.is_finite() {
                self.last[j] = damping;
            } else {
                out.held = true;
            }
        }
        out.damping = self.last;
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lag_under_a_spring_shows_as_stiffness_times_delay_and_stays_at_a_reversal() {
        let k = Constants {
            dt_s: 5e-4,
            hold_share: 0.05,
            peak_memory: 0.999,
        };
        let (stiffness, du) = (158e3_f32, 1e-4_f32);
        let now = |du: f32| Observation {
            command_m: [0.0],
            increment_m: [du],
            displacement_m: [-8.0 * du],
            force_n: [-8.0 * du * stiffness],
        };
        let mut shown = EquivalentDamping::at_rest();
        let first = shown.of(&k, &now(du), &[0.0]);
        assert!((first.damping[0] / (stiffness * 0.004) - 1.0).abs() < 1e-5 && !first.held);
        let turning = shown.of(&k, &now(0.0), &[100.0]);
        assert!(turning.held && turning.damping == first.damping);
    }
}
