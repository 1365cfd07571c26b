//! No force law: the measured force goes into the equation of motion as it is.
//!
//! # When not to use it
//! A late actuator then puts energy into the structure: behind a delay `tau` the damping ratio falls by
//! `omega tau / 2`, and a test whose structure has less runs away. It is the reference for the others, and the law
//! used with a predictor alone.

use super::interface::{Correction, ForceLaw, LawInput, LawOutput};
use crate::context::Context;

/// Stateless.
#[derive(Clone, Debug)]
pub(crate) struct Measured;

impl<const N: usize> ForceLaw<N> for Measured {
    type Constants = ();

    fn design(_: &Context<'_, N>) {}

    fn at_rest((): &()) -> Self {
        Self
    }

    #[inline]
    fn act(
        &mut self,
        (): &(),
        reached: &LawInput<'_, N>,
        shown: &mut Correction<N>,
    ) -> LawOutput<N> {
        LawOutput {
            force_n: reached.now.force_n,
            // None: nothing has been written there.
            damping: shown.damping,
        }
    }
}
