//! Force laws: what acts in the equation of motion so that the actuator's error puts no energy into the structure.
//!
//! A law sees, once an integration step, what was measured where the target was reached, and says with which restoring
//! force and which added damping the equation of motion is solved.
//!
//! | file | law | source |
//! |---|---|---|
//! | [`measured`] | the measured force as it is | |
//! | [`damping`] | variable damping, `eq14-unguarded`, `eq14`, `paper` | the paper, Eqs 14 and 20 |
//! | [`fit`] | force at the time the target was reached, `ahmadizadeh` | Ahmadizadeh et al. 2008 |
//! | [`tangent`] | measured force and tangent stiffness times the way that is left | |
//!
//! A law whose correction is a force is [`Corrected`]: the record shows the damping that the force amounts to
//! ([`equivalent`]).

pub(crate) mod equivalent;
mod sech_gain;

use crate::config::Compensation;
use crate::context::Context;
use crate::energy::{Observation, Windowed};
use crate::linear::LinearForce;
use crate::method::{Force, for_each_method};
use crate::refusal::Refusal;
use equivalent::EquivalentDamping;

/// What the law did in one integration step, for the record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Correction<const N: usize> {
    /// Diagonal of C_cor, N s/m; of a corrected force, the damping that it amounts to.
    pub damping: [f32; N],
    /// G_v of Eq 19; 0 where the law has no gain.
    pub gain: [f32; N],
    /// Some axis kept its last value.
    pub held: bool,
    /// Some axis was at its clamp.
    pub clamped: bool,
}

impl<const N: usize> Correction<N> {
    /// No correction.
    pub const NONE: Self = Self {
        damping: [0.0; N],
        gain: [0.0; N],
        held: false,
        clamped: false,
    };
}

/// What a law sees of an integration step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reached<'a, const N: usize> {
    /// Target, displacement and force.
    pub now: &'a Observation<N>,
    /// Eq 12 over the window.
    pub energy: &'a Windowed<N>,
    /// dt v_{i-1}, m.
    pub velocity_dt_m: [f32; N],
    /// dt v^_i, Eq 16, m.
    pub predictor_velocity_dt_m: [f32; N],
}

/// With what the equation of motion is solved.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Acting<const N: usize> {
    /// Restoring force, N.
    pub force_n: [f32; N],
    /// Diagonal of the added damping, N s/m.
    pub damping: [f32; N],
}

/// A force law.
pub(crate) trait ForceLaw<const N: usize>: Sized {
    /// Constants, worked out once.
    type Constants: Clone + core::fmt::Debug;

    /// Checks the parameters of the law.
    ///
    /// # Errors
    /// The first that cannot be accepted.
    fn check(_: &Compensation) -> Result<(), Refusal> {
        Ok(())
    }

    /// The constants for a test.
    fn design(context: &Context<'_, N>) -> Self::Constants;

    /// What it comes to over a cycle, with `physical` storeys in the laboratory.
    fn linear(c: &Compensation, physical: usize) -> LinearForce;

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// One integration step. `shown` is what the law did in the last one, for the record; of axes without an actuator it
    /// stays as it is.
    fn act(
        &mut self,
        k: &Self::Constants,
        reached: &Reached<'_, N>,
        shown: &mut Correction<N>,
    ) -> Acting<N>;
}

/// A law that puts the force at the target in place of the measured one.
pub(crate) trait Correct<const N: usize>: Sized {
    /// Constants, worked out once.
    type Constants: Clone + core::fmt::Debug;

    /// Checks the parameters of the law.
    ///
    /// # Errors
    /// The first that cannot be accepted.
    fn check(_: &Compensation) -> Result<(), Refusal> {
        Ok(())
    }

    /// The constants for a test.
    fn design(context: &Context<'_, N>) -> Self::Constants;

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// Restoring force at the target, N.
    fn at_target(&mut self, k: &Self::Constants, now: &Observation<N>) -> [f32; N];
}

/// A corrected force and the damping that it amounts to.
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

    fn linear(_: &Compensation, _: usize) -> LinearForce {
        LinearForce::AtTarget
    }

    fn at_rest((k, _): &Self::Constants) -> Self {
        Self {
            force: C::at_rest(k),
            shown: EquivalentDamping::at_rest(),
        }
    }

    /// Hands on a copy, so that what other laws look at can stay in registers.
    #[inline(always)]
    fn act(
        &mut self,
        k: &Self::Constants,
        reached: &Reached<'_, N>,
        shown: &mut Correction<N>,
    ) -> Acting<N> {
        self.correct(k, *reached.now, shown)
    }
}

impl<C: Correct<N>, const N: usize> Corrected<C, N> {
    // A function of its own: what only some laws do is not spread over the step of all.
    #[inline(never)]
    fn correct(
        &mut self,
        (k, k_shown): &(C::Constants, equivalent::Constants),
        now: Observation<N>,
        shown: &mut Correction<N>,
    ) -> Acting<N> {
        let force_n = self.force.at_target(k, &now);
        self.shown.of(k_shown, &now, &force_n, shown);
        Acting {
            force_n,
            damping: [0.0; N],
        }
    }
}

macro_rules! laws {
    (
        forces {$($(#[$doc:meta])* $V:ident $name:literal behind $own:ident = $law:ty $(, file $file:ident)?;)*}
        predictors {$($_predictors:tt)*}
    ) => {
        $($(pub(crate) mod $file;)?)*

        /// The force law of a loop, with its constants and its memory.
        #[derive(Clone, Debug)]
        #[allow(clippy::large_enum_variant)] // There is no heap.
        pub(crate) enum Law<const N: usize> {
            $($(#[$doc])* $V($law, <$law as ForceLaw<N>>::Constants),)*
        }

        impl<const N: usize> Law<N> {
            /// Checks the parameters of all laws.
            ///
            /// # Errors
            /// The first that cannot be accepted.
            pub fn check(c: &Compensation) -> Result<(), Refusal> {
                $(<$law as ForceLaw<N>>::check(c)?;)*
                Ok(())
            }

            /// For a test, at rest at zero.
            pub fn design(context: &Context<'_, N>) -> Self {
                match context.parameters.kind.force {
                    $(Force::$V => {
                        let k = <$law as ForceLaw<N>>::design(context);
                        Self::$V(ForceLaw::<N>::at_rest(&k), k)
                    })*
                }
            }

            /// The linear form of `of`.
            pub fn linear(of: Force, c: &Compensation, physical: usize) -> LinearForce {
                match of {
                    $(Force::$V => <$law as ForceLaw<N>>::linear(c, physical),)*
                }
            }

            /// Back to rest at zero, in place.
            pub fn rest(&mut self) {
                match self {
                    $(Self::$V(law, k) => *law = ForceLaw::<N>::at_rest(k),)*
                }
            }

            /// One integration step.
            #[inline]
            pub fn act(&mut self, reached: &Reached<'_, N>, shown: &mut Correction<N>) -> Acting<N> {
                match self {
                    $(Self::$V(law, k) => law.act(k, reached, shown),)*
                }
            }
        }
    };
}
for_each_method!(laws);

impl Force {
    /// What it comes to over a cycle, with `physical` storeys in the laboratory.
    pub fn linear(self, c: &Compensation, physical: usize) -> LinearForce {
        Law::<1>::linear(self, c, physical)
    }
}
