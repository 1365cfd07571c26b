//! A law whose correction is a force, as a [`ForceLaw`].

use super::equivalent::{self, EquivalentDamping};
use super::interface::{Correct, Correction, ForceLaw, LawInput, LawOutput};
use crate::config::Compensation;
use crate::context::Context;
use crate::energy::Observation;
use crate::refusal::Refusal;

/// A corrected force and its equivalent damping.
#[derive(Clone, Debug)]
pub(crate) struct Corrected<C, const N: usize> {
    force: C,
    shown: EquivalentDamping<N>,
}

impl<C: Correct<N>, const N: usize> ForceLaw<N> for Corrected<C, N> {
    type Constants = (C::Constants, equivalent::Constants);

    fn check(c: &Compensation) -> Result<(), Refusal> {
        C::check(c)
    }

    fn design(context: &Context<'_, N>) -> Self::Constants {
        (C::design(context), equivalent::Constants::design(context))
    }

    fn at_rest((k, _): &Self::Constants) -> Self {
        Self {
            force: C::at_rest(k),
            shown: EquivalentDamping::at_rest(),
        }
    }

    /// Passes a copy on, so that the inputs of other laws can stay in registers.
    #[inline(always)]
    fn act(
        &mut self,
        k: &Self::Constants,
        reached: &LawInput<'_, N>,
        shown: &mut Correction<N>,
    ) -> LawOutput<N> {
        self.correct(k, *reached.now, shown)
    }
}

impl<C: Correct<N>, const N: usize> Corrected<C, N> {
    // Not inlined, so that code of some laws does not burden the step of all.
    #[inline(never)]
    fn correct(
        &mut self,
        (k, k_shown): &(C::Constants, equivalent::Constants),
        now: Observation<N>,
        shown: &mut Correction<N>,
    ) -> LawOutput<N> {
        let force_n = self.force.at_target(k, &now);
        self.shown.of(k_shown, &now, &force_n, shown);
        LawOutput {
            force_n,
            damping: [0.0; N],
        }
    }
}
