//! A force law supplied by the program, on every axis with an actuator.

use super::interface::{AxisOutput, AxisStep, Correction, ForceLaw, LawInput, LawOutput};
use crate::config::Compensation;
use crate::context::Context;
use crate::method::Force;
use crate::own::{ForceCalls, NONE_REGISTERED, Room, registered};
use crate::refusal::Refusal;
use crate::structure::actuated;

/// The state of each axis.
#[derive(Clone, Debug)]
pub(crate) struct OwnForce<const N: usize>([Room; N]);

/// Constants of each axis.
#[derive(Clone, Debug)]
pub(crate) struct Constants<const N: usize> {
    /// `None` if the check has refused the test.
    calls: Option<&'static ForceCalls>,
    axes: [Room; N],
    physical: usize,
}

fn calls() -> Option<&'static ForceCalls> {
    registered().and_then(|own| own.force.as_ref())
}

impl<const N: usize> ForceLaw<N> for OwnForce<N> {
    type Constants = Constants<N>;

    fn check(c: &Compensation) -> Result<(), Refusal> {
        if c.kind.force == Force::OwnForce {
            return (calls().ok_or(NONE_REGISTERED)?.check)(c);
        }
        Ok(())
    }

    fn design(context: &Context<'_, N>) -> Self::Constants {
        let calls = calls();
        let of = |j| calls.map_or(Room::EMPTY, |own| (own.design)(&context.actuator(j)));
        Constants {
            calls,
            axes: core::array::from_fn(of),
            physical: context.physical(),
        }
    }

    fn at_rest(k: &Self::Constants) -> Self {
        let of = |j: usize| k.calls.map_or(Room::EMPTY, |own| (own.at_rest)(&k.axes[j]));
        Self(core::array::from_fn(of))
    }

    #[inline(never)]
    fn act(
        &mut self,
        k: &Self::Constants,
        reached: &LawInput<'_, N>,
        shown: &mut Correction<N>,
    ) -> LawOutput<N> {
        let (now, energy) = (reached.now, reached.energy);
        let mut output = LawOutput {
            force_n: now.force_n,
            damping: [0.0; N],
        };
        let Some(calls) = k.calls else {
            return output;
        };
        for j in 0..actuated::<N>(k.physical) {
            let step = AxisStep {
                command_m: now.command_m[j],
                increment_m: now.increment_m[j],
                displacement_m: now.displacement_m[j],
                force_n: now.force_n[j],
                energy_j: energy.energy_j[j],
                window_m: energy.increment_m[j],
                velocity_dt_m: reached.velocity_dt_m[j],
                predictor_velocity_dt_m: reached.predictor_velocity_dt_m[j],
            };
            let AxisOutput {
                force_n,
                damping_n_s_per_m,
            } = (calls.act)(&mut self.0[j], &k.axes[j], &step);
            (output.force_n[j], output.damping[j]) = (force_n, damping_n_s_per_m);
            shown.damping[j] = damping_n_s_per_m;
        }
        output
    }
}
