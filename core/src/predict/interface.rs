//! A predictor's inputs and traits: [`Predict`] handles all axes together, [`PredictAxis`] one axis at a time.

use crate::config::{Compensation, Timing};
use crate::context::{ActuatorContext, Context};
use crate::refusal::Refusal;
use crate::structure::actuated;

/// The result of an axis's last command.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct LastCommand {
    /// Target that was in force, u_c, m.
    pub target_m: f32,
    /// Command that was in force, m.
    pub sent_m: f32,
    /// Displacement as estimated from the sample, m.
    pub measured_m: f32,
    /// True if the sample is fresh and the test runs, so that it may be learnt from.
    pub learn: bool,
}

/// The motion that an axis is to follow next.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct TargetMotion {
    /// Next target, m.
    pub displacement_m: f32,
    /// Its velocity, m per control step.
    pub velocity_m: f32,
    /// Its acceleration, m per control step squared.
    pub acceleration_m: f32,
}

impl LastCommand {
    /// Of an axis that is not looked at.
    pub const AT_REST: Self = Self {
        target_m: 0.0,
        sent_m: 0.0,
        measured_m: 0.0,
        learn: false,
    };
}

impl TargetMotion {
    /// Of an axis that is not looked at.
    pub const AT_REST: Self = Self {
        displacement_m: 0.0,
        velocity_m: 0.0,
        acceleration_m: 0.0,
    };

    /// The motion `steps` control steps later, at constant acceleration, m.
    #[inline]
    pub fn after(&self, steps: f32) -> f32 {
        self.displacement_m + steps * (self.velocity_m + 0.5 * steps * self.acceleration_m)
    }

    /// The motion `steps` control steps later, at constant acceleration.
    #[inline]
    pub fn led_by(&self, steps: f32) -> Self {
        self.led_at(steps, self.acceleration_m)
    }

    /// The motion `steps` control steps later, at a given acceleration, m per control step squared.
    #[inline]
    pub(crate) fn led_at(&self, steps: f32, acceleration_m: f32) -> Self {
        let gained_m = steps * acceleration_m;
        Self {
            displacement_m: self.displacement_m + steps * (self.velocity_m + 0.5 * gained_m),
            velocity_m: self.velocity_m + gained_m,
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

    /// True if it also uses the motion of axes without an actuator.
    const SEES_ALL: bool = false;

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

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// One control step of the axes `0..physical`: learns from `followed`, and replaces the targets in `command_m`
    /// by the commands to send.
    fn command(
        &mut self,
        k: &Self::Constants,
        followed: &[LastCommand; N],
        ahead: &[TargetMotion; N],
        physical: usize,
        command_m: &mut [f32; N],
    );

    /// Moves what the actuator `axis` has learnt towards the declared values by a bounded step, and forgets it.
    fn unlearn(&mut self, k: &Self::Constants, axis: usize) {
        let _ = (k, axis);
    }
}

/// A predictor that works axis by axis. [`own`](crate::own) has a thirty-line example.
pub trait PredictAxis: Sized {
    /// Constants of an axis, worked out once.
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
    fn design(context: &ActuatorContext<'_>) -> Self::Constants;

    /// At rest at zero.
    fn at_rest(k: &Self::Constants) -> Self;

    /// One control step: learns from `followed` and returns the command to send, m.
    fn command(&mut self, k: &Self::Constants, followed: &LastCommand, ahead: &TargetMotion)
    -> f32;

    /// A control step in which what was learnt moves towards the declared values by a bounded step.
    fn unlearn(&mut self, k: &Self::Constants) {
        let _ = k;
    }
}

/// Compiled once per image, for every number of floors and every axis.
#[inline(never)]
fn design<P: PredictAxis>(context: &ActuatorContext<'_>) -> P::Constants {
    P::design(context)
}

/// The same predictor on every axis.
#[derive(Clone, Debug)]
pub(crate) struct Axes<P, const N: usize>([P; N]);

impl<P: PredictAxis, const N: usize> Predict<N> for Axes<P, N> {
    type Constants = [P::Constants; N];

    const LEARNS: bool = P::LEARNS;

    fn check(c: &Compensation, t: &Timing) -> Result<(), Refusal> {
        P::check(c, t)
    }

    fn design(context: &Context<'_, N>) -> Result<Self::Constants, Refusal> {
        Ok(core::array::from_fn(|j| design::<P>(&context.actuator(j))))
    }

    fn at_rest(k: &Self::Constants) -> Self {
        Self(core::array::from_fn(|j| P::at_rest(&k[j])))
    }

    // Not inlined, so that code of some predictors does not burden the step of all.
    #[inline(never)]
    fn command(
        &mut self,
        k: &Self::Constants,
        followed: &[LastCommand; N],
        ahead: &[TargetMotion; N],
        physical: usize,
        command_m: &mut [f32; N],
    ) {
        for j in 0..actuated::<N>(physical) {
            command_m[j] = self.0[j].command(&k[j], &followed[j], &ahead[j]);
        }
    }

    #[inline(never)]
    fn unlearn(&mut self, k: &Self::Constants, axis: usize) {
        if let (Some(own), Some(k)) = (self.0.get_mut(axis), k.get(axis)) {
            own.unlearn(k);
        }
    }
}
