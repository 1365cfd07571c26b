//! The watches of all actuators of a test, on a board's thread as on a PC.

use super::Watch;
use super::orders::{Alarm, AxisOrders};
use super::state::State;
use super::tap::Block;

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

/// Gives each watch its actuator's block, and has it fill its orders. A bounded piece of work.
pub fn judge<'a>(
    watches: impl Iterator<Item = &'a mut Watch>,
    blocks: &[Block],
    orders: &mut [AxisOrders],
) -> Verdict {
    let mut all = Verdict::NONE;
    for (axis, ((watch, block), orders)) in (0..).zip(watches.zip(blocks).zip(orders)) {
        let changed = watch.add(block);
        *orders = watch.axis_orders();
        all = all.with(Verdict {
            state: watch.state(),
            alarm: watch.alarm(axis),
            changed,
        });
    }
    all
}
