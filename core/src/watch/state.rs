//! The watch's report on a test.

use super::name::Cause;

/// What the watch has to say. The numbers are in records and never change.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[repr(u8)]
pub enum State {
    /// The rig does what its model says.
    #[default]
    Sound = 0,
    /// Something may be wrong.
    Doubtful = 1,
    /// Something is wrong, and it is one of a set.
    Named = 2,
    /// The test has to stop.
    Trip = 3,
}

impl State {
    /// The word in files and on the terminal.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Sound => "sound",
            Self::Doubtful => "doubtful",
            Self::Named => "named",
            Self::Trip => "trip",
        }
    }
}

/// A cause with its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Finding {
    /// The cause.
    pub cause: Cause,
    /// Its value in the unit of the cause.
    pub value: f32,
    /// Its standard deviation.
    pub sd: f32,
}

impl Finding {
    /// The 95 % quantile of the normal distribution.
    const NINETY: f32 = 1.645;

    /// The 90 % interval of the value, in the unit of the cause.
    pub fn interval_90(&self) -> [f32; 2] {
        let half = Self::NINETY * self.sd;
        [self.value - half, self.value + half]
    }
}
