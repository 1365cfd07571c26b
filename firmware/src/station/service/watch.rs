//! The watch of the test in force.

use super::{CommandResult, Pending, Service};
use crate::station::order::Order;
use crate::station::period::Report;
use link::MAX_ACTUATORS;
use link::reply::Obstacle;
use link::status::NamedCause;
use outerloop_core::watch::{Instructions, Seen, State, steps_in_block};
use outerloop_core::{Mode, Refusal};

impl Service {
    /// Takes the instructions for the watch of an actuator, from 0. The last of them starts the watch of the test.
    pub(super) fn watch(&mut self, actuator: u8, told: &Instructions) -> CommandResult {
        if usize::from(actuator) >= self.board.actuators {
            return self.no_actuator(actuator);
        }
        let Some(test) = &self.test else {
            return self.reply(self.rejected(None, Some(Obstacle::NotConfigured)));
        };
        if test.coupled.is_some() {
            return self.not_of_coupled("watch");
        }
        // Counted like the loop's.
        let steps = steps_in_block(test.config.timing.rate_hz);
        if self.mode != Mode::Idle {
            return self.reply(self.rejected(None, None));
        }
        match self.tell(actuator, told, steps) {
            Err(refusal) => self.reply(refusal.into()),
            Ok(()) if self.watchers.count() < self.board.actuators => {
                self.done(self.tick, self.mode)
            }
            Ok(()) => self.order(Order::Watch(self.watchers.corrects()), Pending::Done),
        }
    }

    fn tell(&mut self, actuator: u8, told: &Instructions, steps: u32) -> Result<(), Refusal> {
        let refused = |name, value, accepted| {
            Err(Refusal {
                name,
                value,
                accepted,
            })
        };
        if usize::from(actuator) != self.watchers.count() {
            let accepted = "each of the board's actuators once, in turn, after the test";
            return refused("watch: actuator", f64::from(actuator) + 1.0, accepted);
        }
        let rate_hz = told.declared.rate_hz;
        if rate_hz as f32 != self.rate_hz {
            return refused("watch: rate_hz", rate_hz, "the rate of the test in force");
        }
        let correction_ticks = self.board.clock.correction_ticks;
        if told.corrects() && self.left_ticks < correction_ticks {
            let accepted = "nothing to correct for, or a test whose step, timed on this board, leaves at least 350 cycles of its deadline for it (see identify)";
            return refused("watch.correct", f64::from(self.left_ticks), accepted);
        }
        self.watchers.tell(told, steps)
    }

    /// Passes a step to the rig watch; true if its verdict has changed.
    pub(super) fn watch_step(&mut self, report: &Report) -> bool {
        if self.mode == Mode::Idle {
            self.watchers.forget_test();
        }
        let mut seen = [Seen::default(); MAX_ACTUATORS];
        let each = seen.iter_mut().zip(&report.watched.sent_m);
        for (actuator, ((place, sent_m), (lines, _))) in each.zip(&self.calibrations).enumerate() {
            let lines = lines.first();
            let [displacement, force] = report.step.codes(actuator).unwrap_or_default();
            // As computed by the control interrupt from the same codes.
            *place = [
                *sent_m,
                lines.displacement.quantity(displacement),
                lines.force.quantity(force),
            ];
        }
        let (test, now) = (report.watched.test, self.board.now);
        self.watchers.observe(report.tick, test, &seen, now)
    }

    /// The state from the rig watch, of the worst actuator.
    pub fn watch_state(&self) -> State {
        self.watchers.state()
    }

    /// Named causes of each actuator, and the part corrected for.
    pub fn named(&self) -> impl Iterator<Item = NamedCause> {
        self.watchers.named()
    }

    /// True if the compensation's learning is held.
    pub fn is_held(&self) -> bool {
        self.watchers.holds()
    }
}
