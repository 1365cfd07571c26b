//! What the watches of all actuators say together.

use super::orders::Alarm;
use super::state::State;

/// What all of them say of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verdict {
    /// Of the worst.
    pub state: State,
    /// Of the first that has one.
    pub alarm: Option<Alarm>,
    /// State or set of one of them have changed.
    pub changed: bool,
}

impl Verdict {
    /// Nothing stands out.
    pub const NONE: Self = Self {
        state: State::Sound,
        alarm: None,
        changed: false,
    };

    /// And what others say.
    pub fn with(self, other: Self) -> Self {
        Self {
            state: self.state.max(other.state),
            alarm: self.alarm.or(other.alarm),
            changed: self.changed | other.changed,
        }
    }
}
