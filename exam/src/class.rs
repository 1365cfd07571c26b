//! Classes of cases and their options.

/// The kind of question that a case is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Class {
    /// One effect in its textbook form.
    Matched,
    /// One effect by equations other than the textbook's.
    Unseen,
    /// Nothing but parameters that are wrong within their tolerance.
    Clean,
    /// Something that the effect list has no name for.
    Outside,
    /// Two effects of different families, in one channel or in both.
    Two,
    /// One effect, in a record that can hardly tell it from its neighbours.
    Confounded,
}

impl Class {
    /// All classes.
    pub const ALL: [Self; 6] = [
        Self::Matched,
        Self::Unseen,
        Self::Clean,
        Self::Outside,
        Self::Two,
        Self::Confounded,
    ];

    /// The name in tables and file names.
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

/// Options of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Rms of the sensors' noise over their full scale (one side).
    pub noise_ratio: f64,
    /// Smallest and largest size of an effect beyond what the declared parameters can absorb, in units of the channel's floor.
    pub size: (f64, f64),
}

impl Default for Options {
    /// The nominal noise, 0.1 % of full scale, and sizes of 5 to 50 floors.
    fn default() -> Self {
        Self {
            noise_ratio: 1e-3,
            size: (5.0, 50.0),
        }
    }
}
