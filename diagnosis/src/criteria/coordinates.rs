//! Thresholds of the search in the matrices of several coordinates, each with its reason.

// Entries that are named.

/// Price of an entry that is given up, nats: together with the evidence needed against the declaration at all, a single
/// one is named from some five standard deviations on, and each of several from some four.
pub const ENTRY: f64 = 5.0;
/// Rounding, as a fraction of an entry.
pub const ROUNDING: f64 = 1e-6;

// Entries that should be equal but are not.

/// Two entries differ if by more than this many standard deviations
pub const SURE: f64 = 4.0;
/// and by more than this fraction of the force's largest term.
pub const SHARE: f64 = 0.05;
