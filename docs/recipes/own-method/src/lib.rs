//! A predictor of our own: the motion ahead by a share of the actuator's delay, where the share is the test's.
#![cfg_attr(target_os = "none", no_std)]

use bytemuck::{Pod, Zeroable};
use outerloop_core::config::{Compensation, Timing};
use outerloop_core::own::OwnMethods;
use outerloop_core::{ActuatorContext, LastCommand, PredictAxis, Refusal, TargetMotion, accept};

/// What this laboratory brings. The tool, the image for the board and that for QEMU register it when they start.
pub static METHODS: OwnMethods = OwnMethods::NONE.with_predictor::<ShareOfDelay>();

/// `u + s v + s^2/2 a` with `s` the share times the delay, in control steps. It has no memory.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct ShareOfDelay;

impl PredictAxis for ShareOfDelay {
    /// Control steps ahead.
    type Constants = f32;

    fn check(c: &Compensation, _: &Timing) -> Result<(), Refusal> {
        let share = c.own.first().copied().unwrap_or(f64::NAN);
        accept(
            "compensation.own, the share of the delay",
            share,
            c.own.len() == 1 && (0.0..=1.5).contains(&share),
            "one number from 0 to 1.5",
        )
    }

    fn design(context: &ActuatorContext<'_>) -> f32 {
        let share = context.parameters.own.first().copied().unwrap_or(0.0);
        (share * context.delay_steps()) as f32
    }

    fn at_rest(_: &f32) -> Self {
        Self
    }

    fn command(&mut self, steps: &f32, _: &LastCommand, ahead: &TargetMotion) -> f32 {
        ahead.after(*steps)
    }
}
