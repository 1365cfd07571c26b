//! What the watch asks of the loop: to hold an adaptive compensation, to correct, to trip.

use super::state::State;
use crate::record::flag;

/// What is asked for one actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisOrders {
    /// The command is sent ahead by so many control steps more than the test file says.
    pub lead_steps: f32,
    /// What the command is multiplied with.
    pub command_scale: f32,
    /// The displacement is read so many control steps late.
    pub reading_late_steps: f32,
    /// What an adaptive compensation has learnt goes back to what was declared, and stays there.
    pub hold: bool,
}

impl AxisOrders {
    /// Nothing.
    pub const NONE: Self = Self {
        lead_steps: 0.0,
        command_scale: 1.0,
        reading_late_steps: 0.0,
        hold: false,
    };

    fn corrects(&self) -> bool {
        self.lead_steps != 0.0 || self.command_scale != 1.0 || self.reading_late_steps != 0.0
    }
}

/// Why the watch stops a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Alarm {
    /// Which actuator, from 0.
    pub axis: u8,
    /// Predicted error, of the planned peak; 0 where a sensor stands still.
    pub value: f32,
    /// Its declared limit; 0 where a sensor stands still.
    pub limit: f32,
}

/// What is asked of a loop with `N` axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orders<const N: usize> {
    /// Of each actuator.
    pub axes: [AxisOrders; N],
    /// What the watch says, of the worst of them.
    pub state: State,
    /// The test has to stop.
    pub alarm: Option<Alarm>,
}

impl<const N: usize> Orders<N> {
    /// Nothing.
    pub const NONE: Self = Self {
        axes: [AxisOrders::NONE; N],
        state: State::Sound,
        alarm: None,
    };

    /// As [`flag`] bits of a record.
    pub fn flags(&self) -> u32 {
        let mut flags = (self.state as u32) << flag::WATCH_STATE_SHIFT;
        if self.axes.iter().any(|axis| axis.hold) {
            flags |= flag::GUARDED;
        }
        if self.axes.iter().any(AxisOrders::corrects) {
            flags |= flag::ADJUSTED;
        }
        flags
    }
}
