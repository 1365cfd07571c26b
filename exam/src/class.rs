//! Classes of cases, and what can be chosen about them.

/// What kind of question a case is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Class {
    /// One effect in its textbook form.
    Matched,
    /// One effect by other equations.
    Unseen,
    /// Nothing but parameters that are off within their tolerance.
    Clean,
    /// Something that the effect list has no name for.
    Outside,
    /// Two effects of different families, in one channel or in both.
    Two,
    /// One effect, in a record that can hardly tell it from its neighbours.
    Confounded,
}

impl Class {
    /// All.
    pub const ALL: [Self; 6] = [
        Self::Matched,
        Self::Unseen,
        Self::Clean,
        Self::Outside,
        Self::Two,
        Self::Confounded,
    ];

    /// In tables and file names.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Matched => "matched",
            Self::Unseen => "unseen",
            Self::Clean => "clean",
            Self::Outside => "outside",
            Self::Two => "two",
            Self::Confounded => "confounded",
        }
    }
}

/// What can be chosen about a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Rms of the sensors' noise over their full scale (one way).
    pub noise_ratio: f64,
    /// Smallest and largest size of an effect beyond what declared parameters take up, in units of the channel's floor.
    pub size: (f64, f64),
}

impl Default for Options {
    /// Nominal noise, 0.1 % of range.
    fn default() -> Self {
        Self {
            noise_ratio: 1e-3,
            size: (5.0, 50.0),
        }
    }
}
