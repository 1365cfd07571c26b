//! Corrects an actuator's command for its gain and offset.

/// From command to true displacement: `gain * command + offset`.
#[derive(Clone, Copy, Debug)]
pub struct CommandMap {
    per_gain: f32,
    offset_m: f32,
}

impl CommandMap {
    /// From checked parameters.
    pub(crate) fn new(gain: f64, offset_m: f64) -> Self {
        Self {
            per_gain: (1.0 / gain) as f32,
            offset_m: offset_m as f32,
        }
    }

    /// The command that brings the actuator to `aim_m`, m.
    #[inline]
    pub(crate) fn towards(&self, aim_m: f32) -> f32 {
        (aim_m - self.offset_m) * self.per_gain
    }
}
