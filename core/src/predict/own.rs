//! A predictor supplied by the program, on every axis.

use super::interface::{LastCommand, Predict, TargetMotion};
use crate::config::{Compensation, Timing};
use crate::context::Context;
use crate::method::Prediction;
use crate::own::{NONE_REGISTERED, PredictorCalls, Room, registered};
use crate::refusal::Refusal;
use crate::structure::actuated;

/// The memory of each axis.
#[derive(Clone, Debug)]
pub(crate) struct OwnPredictor<const N: usize>([Room; N]);

fn calls() -> Result<&'static PredictorCalls, Refusal> {
    let own = registered().and_then(|own| own.predictor.as_ref());
    own.ok_or(NONE_REGISTERED)
}

impl<const N: usize> Predict<N> for OwnPredictor<N> {
    type Constants = (&'static PredictorCalls, [Room; N]);

    // Unknown, so assume that it learns.
    const LEARNS: bool = true;

    fn check(c: &Compensation, t: &Timing) -> Result<(), Refusal> {
        if c.kind.predictor == Prediction::Own {
            return (calls()?.check)(c, t);
        }
        Ok(())
    }

    fn design(context: &Context<'_, N>) -> Result<Self::Constants, Refusal> {
        let calls = calls()?;
        let of = |j| (calls.design)(&context.actuator(j));
        Ok((calls, core::array::from_fn(of)))
    }

    fn at_rest((calls, k): &Self::Constants) -> Self {
        Self(core::array::from_fn(|j| (calls.at_rest)(&k[j])))
    }

    #[inline(never)]
    fn command(
        &mut self,
        (calls, k): &Self::Constants,
        followed: &[LastCommand; N],
        ahead: &[TargetMotion; N],
        physical: usize,
        command_m: &mut [f32; N],
    ) {
        for j in 0..actuated::<N>(physical) {
            command_m[j] = (calls.command)(&mut self.0[j], &k[j], &followed[j], &ahead[j]);
        }
    }

    fn unlearn(&mut self, (calls, k): &Self::Constants, axis: usize) {
        if let (Some(own), Some(k)) = (self.0.get_mut(axis), k.get(axis)) {
            (calls.unlearn)(own, k);
        }
    }
}
