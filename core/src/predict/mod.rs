//! Predictors: shape the command so that the actuator, which is late, reaches the target in time.
//!
//! A predictor stands between signal generation and the sent command, axis by axis, once a control step. It sees the
//! result of the last command ([`LastCommand`]) and where the motion goes ([`TargetMotion`]). The "command" of the
//! integration and the energies remains the target; only the actuator, the interlocks on the command and the
//! estimator's known input see what is sent.
//!
//! | file | method | source |
//! |---|---|---|
//! | [`lagrange`] | polynomial extrapolation | Horiuchi et al. 1999 |
//! | [`darby`] | the same, with the delay estimated online | Darby et al. 2002 |
//! | [`model`] | prediction by the structure's own model | Carrion and Spencer 2007 |
//! | [`phase_lead`] | first-order phase lead | Zhao et al. 2003 |
//! | [`mcs`] | minimal control synthesis, modified demand | Bonnet et al. 2007 |
//! | [`feedforward_feedback`] | inverse model and feedback of the error | Carrion et al. 2009 |
//! | [`afp`] | adaptive forward prediction | Wallace et al. 2005 |
//! | [`inverse`], [`adaptive_inverse`] | inverse compensation | Chen and Ricles 2009, 2010 |
//! | [`ats`] | adaptive time series | Chae et al. 2013 |
//! | [`amb`] | adaptive model-based compensation | Galmez and Fermandois 2022 |
//! | [`hydraulic`] | inverse of an estimated servo-hydraulic actuator | |
//!
//! Adaptive predictors share [`adaptation`]: off until the motion is worth learning from, bounded, rate limited. Those
//! that use past targets share [`past`].

pub(crate) mod adaptation;
impl Prediction {
    /// True if it learns while a test runs.
    pub fn learns(self) -> bool {
        Predictor::<1>::learns(self)
    }
}

#[cfg(test)]
mod checks;
mod interface;
mod past;

use interface::Axes;
pub(crate) use interface::Predict;
pub use interface::{LastCommand, PredictAxis, TargetMotion};

use crate::config::{Compensation, Timing};
use crate::context::Context;
#[allow(unused_imports)] // A build with every method leaves none out.
use crate::method::left_out;
use crate::method::{Prediction, for_each_method};
use crate::refusal::Refusal;

macro_rules! predictors {
    (
        forces {$($_forces:tt)*}
        predictors {$($(#[$doc:meta])* $number:literal $V:ident $name:literal = $axes:ty $(, file $file:ident)? $(, feature $feature:literal)?;)*}
    ) => {
        $($(#[cfg(feature = $feature)])? $(pub(crate) mod $file;)?)*

        /// A loop's predictor, with its constants and its state.
        #[derive(Clone, Debug)]
        #[allow(clippy::large_enum_variant)] // There is no heap.
        pub(crate) enum Predictor<const N: usize> {
            /// The target is sent as it is.
            None,
            $($(#[$doc])* $(#[cfg(feature = $feature)])? $V($axes, <$axes as Predict<N>>::Constants),)*
        }

        impl<const N: usize> Predictor<N> {
            /// Checks the parameters of all predictors.
            ///
            /// # Errors
            /// The first that cannot be accepted.
            pub fn check(c: &Compensation, t: &Timing) -> Result<(), Refusal> {
                $($(#[cfg(feature = $feature)])? <$axes as Predict<N>>::check(c, t)?;)*
                Ok(())
            }

            /// The predictor for a test, at rest at zero.
            ///
            /// # Errors
            /// The structure allows none.
            pub fn design(context: &Context<'_, N>) -> Result<Self, Refusal> {
                Ok(match context.parameters.kind.predictor {
                    Prediction::None => Self::None,
                    $($(#[cfg(feature = $feature)])? Prediction::$V => {
                        let k = <$axes as Predict<N>>::design(context)?;
                        Self::$V(Predict::<N>::at_rest(&k), k)
                    })*
                    $($(#[cfg(not(feature = $feature))] Prediction::$V => return left_out!($number, $name, $feature),)?)*
                })
            }

            /// True if `of` learns while a test runs.
            pub fn learns(of: Prediction) -> bool {
                match of {
                    Prediction::None => false,
                    $($(#[cfg(feature = $feature)])? Prediction::$V => <$axes as Predict<N>>::LEARNS,)*
                    $($(#[cfg(not(feature = $feature))] Prediction::$V => false,)?)*
                }
            }

            /// True if the predictor also uses the motion of axes without an actuator.
            pub fn sees_all(&self) -> bool {
                match self {
                    Self::None => false,
                    $($(#[cfg(feature = $feature)])? Self::$V(..) => <$axes as Predict<N>>::SEES_ALL,)*
                }
            }

            /// Back to rest at zero, in place.
            pub fn rest(&mut self) {
                match self {
                    Self::None => {}
                    $($(#[cfg(feature = $feature)])? Self::$V(axes, k) => *axes = Predict::<N>::at_rest(k),)*
                }
            }

            /// Moves what `axis` has learnt towards the declared values by a bounded step, before its next command.
            pub fn unlearn(&mut self, axis: usize) {
                match self {
                    Self::None => {}
                    $($(#[cfg(feature = $feature)])? Self::$V(axes, k) => Predict::<N>::unlearn(axes, k, axis),)*
                }
            }

            /// One control step of the axes `0..physical`: replaces the targets in `command_m` by the commands to send.
            pub fn command(
                &mut self,
                followed: &[LastCommand; N],
                ahead: &[TargetMotion; N],
                physical: usize,
                command_m: &mut [f32; N],
            ) {
                match self {
                    Self::None => {}
                    $($(#[cfg(feature = $feature)])? Self::$V(axes, k) => axes.command(k, followed, ahead, physical, command_m),)*
                }
            }
        }
    };
}
for_each_method!(predictors);
