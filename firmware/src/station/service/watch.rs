//! The watch of the test in force.

use super::{CommandResult, Pending, Service};
use crate::station::order::Order;
use link::reply::Obstacle;
use outerloop_core::watch::{Finding, Instructions, State, steps_in_block};
use outerloop_core::{Mode, Refusal};

impl Service {
    /// Takes in what the watch of an actuator, from 0, is told. With the last of them the test is watched.
    pub(super) fn watch(&mut self, actuator: u8, told: &Instructions) -> CommandResult {
        if usize::from(actuator) >= self.board.actuators {
            return self.no_actuator(actuator);
        }
        let Some(config) = &self.config else {
            return self.reply(self.rejected(None, Some(Obstacle::NotConfigured)));
        };
        // As the loop counts them.
        let steps = steps_in_block(config.timing.rate_hz);
        if self.state != Mode::Idle {
            return self.reply(self.rejected(None, None));
        }
        match self.tell(actuator, told, steps) {
            Err(refusal) => self.reply(refusal.into()),
            Ok(()) if self.watchers.count() < self.board.actuators => {
                self.done(self.tick, self.state)
            }
            Ok(()) => self.order(Order::Watch(self.watchers.corrects()), Pending::Done),
        }
    }

    fn tell(&mut self, actuator: u8, told: &Instructions, steps: u16) -> Result<(), Refusal> {
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
        self.watchers.tell(told, steps)
    }

    /// Has the rig watch judge what has come since; true if what it says has changed. Asked for more often than every 16 ms, or
    /// the watch ends.
    pub fn judge(&mut self) -> bool {
        self.watchers.judge(self.board.now)
    }

    /// What the rig watch says, of the worst actuator.
    pub fn watch_state(&self) -> State {
        self.watchers.state()
    }

    /// What it names: the actuator, from 1, and a cause of its set with its value.
    pub fn findings(&self) -> impl Iterator<Item = (usize, &Finding)> {
        self.watchers.findings()
    }
}
