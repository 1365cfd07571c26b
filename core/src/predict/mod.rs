//! Predictors: what is sent so that the actuator, which is late, is at the target in time.
//!
//! A predictor stands between signal generation and the sent command, axis by axis, once a control step. It sees what
//! has come of the last command ([`Followed`]) and where the motion goes ([`Ahead`]). What the integration and the
//! energies call the command stays the target; only the actuator, the interlocks on the command and the estimator's
//! known input see what is sent.
//!
//! | file | method | source |
//! |---|---|---|
//! | [`lagrange`] | polynomial extrapolation | Horiuchi et al. 1999 |
//! | [`darby`] | the same, its delay estimated on line | Darby et al. 2002 |
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
//! that look back share [`past`].

pub(crate) mod adaptation;
impl Prediction {
    /// Whether it learns while a test runs.
    pub fn learns(self) -> bool {
        Predictor::<1>::learns(self)
    }

    /// Its linear form in a test.
    pub fn linear(self, setting: &mut Setting<'_>) -> Linear {
        Predictor::<1>::linear(self, setting)
    }
}

#[cfg(test)]
mod checks;
mod past;

use crate::config::{Compensation, Timing};
use crate::context::Context;
use crate::linear::{Linear, Setting, Sum};
use crate::method::{Prediction, for_each_method};
use crate::refusal::Refusal;
use crate::structure::actuated;

/// What has come of the last command of an axis.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Followed {
    /// Target that was in force, u_c, m.
    pub target_m: f32,
    /// Command that was in force, m.
    pub sent_m: f32,
    /// Displacement as estimated from the sample, m.
    pub measured_m: f32,
    /// The sample is fresh and the test runs: it may be learnt from.
    pub learn: bool,
}

/// Where the motion of an axis goes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ahead {
    /// Next target, m.
    pub displacement_m: f32,
    /// Its velocity, m per control step.
    pub velocity_m: f32,
    /// Its acceleration, m per control step squared.
    pub acceleration_m: f32,
}

impl Ahead {
    /// The motion `steps` control steps later, at constant acceleration, m.
    #[inline]
    pub fn after(&self, steps: f32) -> f32 {
        self.displacement_m + steps * (self.velocity_m + 0.5 * steps * self.acceleration_m)
    }

    /// The motion `steps` control steps later, at constant acceleration.
    #[inline]
    pub fn led_by(&self, steps: f32) -> Self {
        Self {
            displacement_m: self.after(steps),
            velocity_m: self.velocity_m + steps * self.acceleration_m,
            acceleration_m: self.acceleration_m,
        }
    }
}

/// A predictor that sees all axes.
pub(crate) trait Predict<const N: usize>: Sized {
    /// Constants, worked out once.
    type Constants: Clone + core::fmt::Debug;

    /// It learns while a test runs.
    const LEARNS: bool = false;

    /// Checks the parameters of the predictor.
    ///
    /// # Errors
    /// The first that cannot be accepted.
    fn check(_: &Compensation, _: &Timing) -> Result<(), Refusal> {
        Ok(())
    }

    /// The constants for a test.
    ///
    /// # Errors
    /// A structure for which there are none.
    fn design(context: &Context<'_, N>) -> Result<Self::Constants, Refusal>;

    /// As a linear system; of an adaptive law, with what the setting says that it knows.
    fn linear(setting: &mut Setting<'_>) -> Linear;

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// One control step of the axes `0..physical`: learns from what was followed, and replaces the targets in
    /// `command_m` by what is to be sent.
    fn command(
        &mut self,
        k: &Self::Constants,
        followed: &[Followed; N],
        ahead: &[Ahead; N],
        physical: usize,
        command_m: &mut [f32; N],
    );
}

/// A predictor that works axis by axis.
pub(crate) trait PredictAxis: Sized {
    /// Constants, worked out once; the same for every axis.
    type Constants: Clone + core::fmt::Debug;

    /// It learns while a test runs.
    const LEARNS: bool = false;

    /// Checks the parameters of the predictor.
    ///
    /// # Errors
    /// The first that cannot be accepted.
    fn check(_: &Compensation, _: &Timing) -> Result<(), Refusal> {
        Ok(())
    }

    /// The constants for a test.
    fn design<const N: usize>(context: &Context<'_, N>) -> Self::Constants;

    /// As a linear system; of an adaptive law, with what the setting says that it knows.
    fn linear(setting: &mut Setting<'_>) -> Linear;

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// One control step: learns from what was followed and gives the command to send, m.
    fn command(&mut self, k: &Self::Constants, followed: &Followed, ahead: &Ahead) -> f32;
}

/// The same predictor on every axis.
#[derive(Clone, Debug)]
pub(crate) struct Axes<P, const N: usize>([P; N]);

impl<P: PredictAxis, const N: usize> Predict<N> for Axes<P, N> {
    type Constants = P::Constants;

    const LEARNS: bool = P::LEARNS;

    fn check(c: &Compensation, t: &Timing) -> Result<(), Refusal> {
        P::check(c, t)
    }

    fn design(context: &Context<'_, N>) -> Result<Self::Constants, Refusal> {
        Ok(P::design(context))
    }

    fn linear(setting: &mut Setting<'_>) -> Linear {
        P::linear(setting)
    }

    fn at_rest(k: &Self::Constants) -> Self {
        Self(core::array::from_fn(|_| P::at_rest(k)))
    }

    // A function of its own: what only some predictors do is not spread over the step of all.
    #[inline(never)]
    fn command(
        &mut self,
        k: &Self::Constants,
        followed: &[Followed; N],
        ahead: &[Ahead; N],
        physical: usize,
        command_m: &mut [f32; N],
    ) {
        for j in 0..actuated::<N>(physical) {
            command_m[j] = self.0[j].command(k, &followed[j], &ahead[j]);
        }
    }
}

macro_rules! predictors {
    (
        forces {$($_forces:tt)*}
        predictors {$($(#[$doc:meta])* $V:ident $name:literal = $axes:ty $(, file $file:ident)?;)*}
    ) => {
        $($(pub(crate) mod $file;)?)*

        /// The predictor of a loop, with its constants and its memory.
        #[derive(Clone, Debug)]
        #[allow(clippy::large_enum_variant)] // There is no heap.
        pub(crate) enum Predictor<const N: usize> {
            /// The target is sent as it is.
            None,
            $($(#[$doc])* $V($axes, <$axes as Predict<N>>::Constants),)*
        }

        impl<const N: usize> Predictor<N> {
            /// Checks the parameters of all predictors.
            ///
            /// # Errors
            /// The first that cannot be accepted.
            pub fn check(c: &Compensation, t: &Timing) -> Result<(), Refusal> {
                $(<$axes as Predict<N>>::check(c, t)?;)*
                Ok(())
            }

            /// For a test, at rest at zero.
            ///
            /// # Errors
            /// A structure for which there is none.
            pub fn design(context: &Context<'_, N>) -> Result<Self, Refusal> {
                Ok(match context.parameters.kind.predictor {
                    Prediction::None => Self::None,
                    $(Prediction::$V => {
                        let k = <$axes as Predict<N>>::design(context)?;
                        Self::$V(Predict::<N>::at_rest(&k), k)
                    })*
                })
            }

            /// Whether `of` learns while a test runs.
            pub fn learns(of: Prediction) -> bool {
                match of {
                    Prediction::None => false,
                    $(Prediction::$V => <$axes as Predict<N>>::LEARNS,)*
                }
            }

            /// The linear form of `of`.
            pub fn linear(of: Prediction, setting: &mut Setting<'_>) -> Linear {
                match of {
                    Prediction::None => Linear::Sum(Sum::TARGET),
                    $(Prediction::$V => <$axes as Predict<N>>::linear(setting),)*
                }
            }

            /// Back to rest at zero, in place.
            pub fn rest(&mut self) {
                match self {
                    Self::None => {}
                    $(Self::$V(axes, k) => *axes = Predict::<N>::at_rest(k),)*
                }
            }

            /// One control step of the axes `0..physical`: replaces the targets in `command_m` by what is to be sent.
            pub fn command(
                &mut self,
                followed: &[Followed; N],
                ahead: &[Ahead; N],
                physical: usize,
                command_m: &mut [f32; N],
            ) {
                match self {
                    Self::None => {}
                    $(Self::$V(axes, k) => axes.command(k, followed, ahead, physical, command_m),)*
                }
            }
        }
    };
}
for_each_method!(predictors);
