//! One actuator, period by period.

use super::load::Load;
use super::random_multiplier::RandomMultiplier;
use super::servo_hydraulic::ServoHydraulic;
use crate::delay_line::DelayLine;
use crate::effect::Additions;
use crate::lag::{FirstOrder, SecondOrder};
use crate::stage::{Stage, Stages};

/// The dynamics of one actuator.
#[derive(Clone, Debug)]
pub(super) enum Dynamics {
    Ideal,
    Delay(DelayLine),
    FirstOrder(FirstOrder),
    SecondOrder { lag: SecondOrder, zeta: f64 },
    LagDelay { line: DelayLine, lag: FirstOrder },
    RandomMultiplier(RandomMultiplier),
    ServoHydraulic(Box<ServoHydraulic>),
}

/// One actuator with its controller.
#[derive(Clone, Debug)]
pub struct Actuator {
    pub(super) dynamics: Dynamics,
    pub(super) gain: f64,
    /// Stages that its motion passes after its dynamics.
    pub(super) motion: Stages,
    pub(super) step_s: f64,
    pub(super) jump: Option<Jump>,
    pub(super) held_m: f64,
    /// Delay and time constant of the actuator's own element, s.
    pub(super) own_s: [f64; 2],
}

/// A pending change of delay.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jump {
    pub(super) steps_left: u64,
    pub(super) delay_s: f64,
}

impl Actuator {
    /// The displacement, m, at the end of the period in which `command_m` was held.
    #[inline]
    pub fn step(&mut self, command_m: f64, load: Load) -> f64 {
        if let Some(jump) = &mut self.jump {
            if jump.steps_left == 0 {
                let delay_s = jump.delay_s;
                self.jump = None;
                self.set_delay(delay_s);
            } else {
                jump.steps_left -= 1;
            }
        }
        // A converter cannot output NaN or infinity: it keeps the last command.
        if command_m.is_finite() {
            self.held_m = command_m;
        }
        let target = self.gain * self.held_m;
        let moved = match &mut self.dynamics {
            Dynamics::Ideal => target,
            Dynamics::Delay(line) => line.step(target),
            Dynamics::FirstOrder(lag) => lag.step(target),
            Dynamics::SecondOrder { lag, .. } => lag.step(target),
            Dynamics::LagDelay { line, lag } => lag.step(line.step(target)),
            Dynamics::RandomMultiplier(block) => block.step(target),
            Dynamics::ServoHydraulic(servo) => servo.step(target, load),
        };
        self.motion.step(moved)
    }

    /// Takes the effects that begin in the next period. A timing error goes into the actuator's own element if its kind
    /// has one, otherwise into a stage after it.
    pub(crate) fn begin(&mut self, mut added: Additions) {
        let h = self.step_s;
        let more_s = [1e-3 * added.delay_ms, 1e-3 * added.lag_ms];
        for (own, more) in self.own_s.iter_mut().zip(more_s) {
            *own += more;
        }
        let [delay_s, lag_s] = self.own_s;
        let mut rest_s = more_s;
        match &mut self.dynamics {
            Dynamics::Delay(line) => {
                line.set_delay(delay_s / h);
                rest_s[0] = 0.0;
            }
            Dynamics::FirstOrder(lag) => {
                lag.set_time_constant(lag_s, h);
                rest_s[1] = 0.0;
            }
            Dynamics::LagDelay { line, lag } => {
                line.set_delay(delay_s / h);
                lag.set_time_constant(lag_s, h);
                rest_s = [0.0; 2];
            }
            Dynamics::Ideal
            | Dynamics::SecondOrder { .. }
            | Dynamics::RandomMultiplier(_)
            | Dynamics::ServoHydraulic(_) => {}
        }
        if rest_s[0] > 0.0 {
            let line = DelayLine::new(rest_s[0] / h, 0.0);
            added.motion.push(Stage::Delay(line));
        }
        if rest_s[1] > 0.0 {
            added.motion.push(Stage::Lag(FirstOrder::new(rest_s[1], h)));
        }
        self.motion.begin(added.motion);
    }

    fn set_delay(&mut self, delay_s: f64) {
        let h = self.step_s;
        match &mut self.dynamics {
            Dynamics::Ideal => {}
            Dynamics::Delay(line) | Dynamics::LagDelay { line, .. } => line.set_delay(delay_s / h),
            Dynamics::FirstOrder(lag) => lag.set_time_constant(delay_s, h),
            Dynamics::SecondOrder { lag, zeta } => lag.set_delay(delay_s, *zeta, h),
            Dynamics::RandomMultiplier(block) => block.set_delay(delay_s, h),
            Dynamics::ServoHydraulic(servo) => servo.set_delay(delay_s),
        }
    }
}
