//! The equivalent damping of a force correction, for the paper's plot and the check for locked structures.

use super::interface::Correction;
use crate::context::Context;
use crate::energy::Observation;
use crate::float::larger;
use crate::structure::actuated;

/// Constants of the report.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Integration step, s of model time.
    pub dt_s: f32,
    /// Fraction of the running peak increment below which the last value is held.
    pub hold_share: f32,
    /// Decay factor of the running peak per integration step.
    pub peak_memory: f32,
    /// Number of axes in the laboratory.
    pub physical: usize,
}

impl Constants {
    /// The constants for a test.
    pub fn design<const N: usize>(context: &Context<'_, N>) -> Self {
        Self {
            dt_s: context.model_step_s as f32,
            hold_share: context.parameters.hold_share as f32,
            peak_memory: context.peak_memory(),
            physical: context.physical(),
        }
    }
}

/// `F_cor dt / du`; the last value is held where du is too small to divide by.
#[derive(Clone, Debug)]
pub(crate) struct EquivalentDamping<const N: usize> {
    peak_m: [f32; N],
}

impl<const N: usize> EquivalentDamping<N> {
    /// Nothing yet.
    pub const fn at_rest() -> Self {
        Self { peak_m: [0.0; N] }
    }

    /// The equivalent damping of the corrected force; replaces the last reported value.
    #[inline]
    pub fn of(
        &mut self,
        k: &Constants,
        now: &Observation<N>,
        corrected_n: &[f32; N],
        shown: &mut Correction<N>,
    ) {
        let mut held = false;
        for j in 0..actuated::<N>(k.physical) {
            let du = now.increment_m[j];
            self.peak_m[j] = larger(k.peak_memory * self.peak_m[j], du.abs());
            let damping = (corrected_n[j] - now.force_n[j]) * k.dt_s / du;
            if du.abs() > k.hold_share * self.peak_m[j] && damping.is_finite() {
                shown.damping[j] = damping;
            } else {
                held = true;
            }
        }
        shown.held = held;
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
            physical: 1,
        };
        let (stiffness, du) = (158e3_f32, 1e-4_f32);
        let now = |du: f32| Observation {
            command_m: [0.0],
            increment_m: [du],
            displacement_m: [-8.0 * du],
            force_n: [-8.0 * du * stiffness],
        };
        let (mut equivalent, mut shown) = (EquivalentDamping::at_rest(), Correction::NONE);
        equivalent.of(&k, &now(du), &[0.0], &mut shown);
        let first = shown;
        assert!((first.damping[0] / (stiffness * 0.004) - 1.0).abs() < 1e-5 && !first.held);
        equivalent.of(&k, &now(0.0), &[100.0], &mut shown);
        assert!(shown.held && shown.damping == first.damping);
    }
}
