//! A force law's inputs and traits: [`ForceLaw`], or [`Correct`] for a law that replaces the measured force.

use crate::config::Compensation;
use crate::context::{ActuatorContext, Context};
use crate::energy::{Observation, Windowed};
use crate::refusal::Refusal;

/// What the law did in one integration step, for the record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Correction<const N: usize> {
    /// Diagonal of C_cor, N s/m; for a corrected force, the equivalent damping.
    pub damping: [f32; N],
    /// G_v of Eq 19; 0 if the law has no gain.
    pub gain: [f32; N],
    /// True if some axis kept its last value.
    pub held: bool,
    /// True if some axis was at its clamp.
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
pub(crate) struct LawInput<'a, const N: usize> {
    /// Target, displacement and force.
    pub now: &'a Observation<N>,
    /// Eq 12 over the window.
    pub energy: &'a Windowed<N>,
    /// dt v_{i-1}, m.
    pub velocity_dt_m: [f32; N],
    /// dt v^_i, Eq 16, m.
    pub predictor_velocity_dt_m: [f32; N],
}

/// The law's output to the equation of motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawOutput<const N: usize> {
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

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// One integration step. `shown` is the law's action in the last one, for the record; axes without an actuator
    /// stay unchanged.
    fn act(
        &mut self,
        k: &Self::Constants,
        reached: &LawInput<'_, N>,
        shown: &mut Correction<N>,
    ) -> LawOutput<N>;
}

/// What a law that works axis by axis sees of an integration step.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct AxisStep {
    /// Target that has been reached, u_c, m.
    pub command_m: f32,
    /// Change of the target since the last step, m.
    pub increment_m: f32,
    /// Estimated displacement of the specimen, u_m, m.
    pub displacement_m: f32,
    /// Estimated restoring force, R_m, N.
    pub force_n: f32,
    /// Eq 12 over the window, J: negative if the actuator has put energy in.
    pub energy_j: f32,
    /// Change of the target over the window, m.
    pub window_m: f32,
    /// dt v_{i-1}, m.
    pub velocity_dt_m: f32,
    /// dt v^_i, Eq 16, m.
    pub predictor_velocity_dt_m: f32,
}

/// An [`AxisLaw`]'s output to the equation of motion.
#[derive(Clone, Copy, Debug)]
pub struct AxisOutput {
    /// Restoring force, N.
    pub force_n: f32,
    /// Added damping, N s/m.
    pub damping_n_s_per_m: f32,
}

/// A force law that works axis by axis; [`own`](crate::own) shows how a program supplies one.
pub trait AxisLaw: Sized {
    /// Constants of an axis, worked out once.
    type Constants: Clone + core::fmt::Debug;

    /// Checks the parameters of the law.
    ///
    /// # Errors
    /// The first that cannot be accepted.
    fn check(_: &Compensation) -> Result<(), Refusal> {
        Ok(())
    }

    /// The constants for a test.
    fn design(context: &ActuatorContext<'_>) -> Self::Constants;

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// One integration step.
    fn act(&mut self, k: &Self::Constants, reached: &AxisStep) -> AxisOutput;
}

/// A law that replaces the measured force by the force at the target.
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
