//! Controllers that are not core's methods.

use super::interface::{Controller, DeclaredPlant};
use super::{baseline, fixed_inverse};

/// A controller that is not one of core's methods.
pub struct Outside {
    /// Its name.
    pub name: &'static str,
    /// What it knows beforehand, for the table.
    pub prior_knowledge: &'static str,
    /// Makes one at rest.
    pub make: fn(&DeclaredPlant) -> Box<dyn Controller>,
}

/// All controllers that are not core's.
pub const OUTSIDE: [Outside; 2] = [
    Outside {
        name: "pi-phase-lead",
        prior_knowledge: "tuned by hand, published",
        make: baseline::make,
    },
    Outside {
        name: "fixed-inverse",
        prior_knowledge: "plant",
        make: fixed_inverse::make,
    },
];
