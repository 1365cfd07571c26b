//! The watch's requests to the loop: to hold an adaptive compensation, to correct, to trip.

use super::state::State;
use crate::record::flag;

/// The requests for one actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisOrders {
    /// Additional lead of the command beyond the test file's, control steps.
    pub lead_steps: f32,
    /// Factor on the command.
    pub command_scale: f32,
    /// Lateness of the displacement reading, control steps.
    pub reading_late_steps: f32,
    /// True if an adaptive compensation must return to its declared values and stay there.
    pub hold: bool,
}

impl AxisOrders {
    /// No request.
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
    /// The actuator, from 0.
    pub axis: u8,
    /// Predicted error, relative to the planned peak; 0 for a frozen sensor.
    pub value: f32,
    /// Its declared limit; 0 for a frozen sensor.
    pub limit: f32,
}

/// The requests to a loop with `N` axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orders<const N: usize> {
    /// For each actuator.
    pub axes: [AxisOrders; N],
    /// The worst state of all of them.
    pub state: State,
    /// Set if the test must stop.
    pub alarm: Option<Alarm>,
}

impl<const N: usize> Orders<N> {
    /// No request.
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
