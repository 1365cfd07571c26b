//! Force laws: act in the equation of motion so that the actuator's error puts no energy into the structure.
//!
//! Once per integration step a law sees the measurements at the reached target and returns the restoring force and
//! added damping with which the equation of motion is solved.
//!
//! | file | law | source |
//! |---|---|---|
//! | [`measured`] | the measured force as it is | |
//! | [`damping`] | variable damping, `eq14-unguarded`, `eq14`, `paper` | the paper, Eqs 14 and 20 |
//! | [`fit`] | force at the time the target was reached, `ahmadizadeh` | Ahmadizadeh et al. 2008 |
//! | [`tangent`] | measured force, and tangent stiffness times the remaining displacement | |
//!
//! A law whose correction is a force is [`Corrected`]: the record shows the damping that the force amounts to
//! ([`equivalent`]).

mod corrected;
pub(crate) mod equivalent;
mod interface;
mod sech_gain;

pub(crate) use interface::{Correction, LawInput, LawOutput};

use crate::config::Compensation;
use crate::context::Context;
#[allow(unused_imports)] // A build with every method leaves none out.
use crate::method::left_out;
use crate::method::{Force, for_each_method};
use crate::refusal::Refusal;
use corrected::Corrected;
pub(crate) use interface::ForceLaw;
pub use interface::{AxisLaw, AxisOutput, AxisStep};

macro_rules! laws {
    (
        forces {$($(#[$doc:meta])* $number:literal $V:ident $name:literal behind $own:ident = $law:ty $(, file $file:ident)? $(, feature $feature:literal)?;)*}
        predictors {$($_predictors:tt)*}
    ) => {
        $($(#[cfg(feature = $feature)])? $(pub(crate) mod $file;)?)*

        /// A loop's force law, with its constants and its state.
        #[derive(Clone, Debug)]
        #[allow(clippy::large_enum_variant)] // There is no heap.
        pub(crate) enum Law<const N: usize> {
            $($(#[$doc])* $(#[cfg(feature = $feature)])? $V($law, <$law as ForceLaw<N>>::Constants),)*
        }

        impl<const N: usize> Law<N> {
            /// Checks the parameters of all laws.
            ///
            /// # Errors
            /// The first that cannot be accepted.
            pub fn check(c: &Compensation) -> Result<(), Refusal> {
                $($(#[cfg(feature = $feature)])? <$law as ForceLaw<N>>::check(c)?;)*
                Ok(())
            }

            /// The law for a test, at rest at zero.
            ///
            /// # Errors
            /// This build does not have the law.
            pub fn design(context: &Context<'_, N>) -> Result<Self, Refusal> {
                Ok(match context.parameters.kind.force {
                    $($(#[cfg(feature = $feature)])? Force::$V => {
                        let k = <$law as ForceLaw<N>>::design(context);
                        Self::$V(ForceLaw::<N>::at_rest(&k), k)
                    })*
                    $($(#[cfg(not(feature = $feature))] Force::$V => return left_out!($number, $name, $feature),)?)*
                })
            }

            /// Back to rest at zero, in place.
            pub fn rest(&mut self) {
                match self {
                    $($(#[cfg(feature = $feature)])? Self::$V(law, k) => *law = ForceLaw::<N>::at_rest(k),)*
                }
            }

            /// One integration step.
            #[inline]
            pub fn act(&mut self, reached: &LawInput<'_, N>, shown: &mut Correction<N>) -> LawOutput<N> {
                match self {
                    $($(#[cfg(feature = $feature)])? Self::$V(law, k) => law.act(k, reached, shown),)*
                }
            }
        }
    };
}
for_each_method!(laws);
