//! What the watch has to say of a test.

use super::name::Cause;

/// What the watch has to say.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// The rig does what its model says.
    #[default]
    Sound,
    /// Something may be wrong.
    Doubtful,
    /// Something is wrong, and it is one of a set.
    Named,
    /// The test has to stop.
    Trip,
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
    /// What.
    pub cause: Cause,
    /// In the unit of the cause.
    pub value: f32,
    /// Its standard deviation.
    pub sd: f32,
}
