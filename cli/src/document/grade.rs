//! How good a result is.

use experiment::soundness::SoundnessVerdict;
use experiment::summary::Validity;

/// How good a result is: its colour on the page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Grade {
    /// Green.
    Good,
    /// Amber.
    Fair,
    /// Red.
    Bad,
}

impl Grade {
    /// Its class in the style sheet.
    pub(super) const fn class(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Fair => "fair",
            Self::Bad => "bad",
        }
    }
}

impl From<Validity> for Grade {
    fn from(validity: Validity) -> Self {
        match validity {
            Validity::Good => Self::Good,
            Validity::Fair => Self::Fair,
            Validity::Bad => Self::Bad,
        }
    }
}

impl From<SoundnessVerdict> for Grade {
    fn from(verdict: SoundnessVerdict) -> Self {
        match verdict {
            SoundnessVerdict::Stable => Self::Good,
            SoundnessVerdict::Doubtful => Self::Fair,
            SoundnessVerdict::Unstable => Self::Bad,
        }
    }
}
