//! The joint verdict of the watches of all actuators.

use super::orders::Alarm;
use super::state::State;

/// Their joint verdict on a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// The worst state.
    pub state: State,
    /// The first alarm.
    pub alarm: Option<Alarm>,
    /// True if the state or set of any of them has changed.
    pub changed: bool,
}

impl Verdict {
    /// Nothing to report.
    pub const NONE: Self = Self {
        state: State::Sound,
        alarm: None,
        changed: false,
    };

    /// Combined with the verdict of others.
    pub fn with(self, other: Self) -> Self {
        Self {
            state: self.state.max(other.state),
            alarm: self.alarm.or(other.alarm),
            changed: self.changed | other.changed,
        }
    }
}
