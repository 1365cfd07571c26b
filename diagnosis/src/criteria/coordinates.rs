//! Thresholds of the search among matrices of several coordinates, each with its reason.

// Entries that are named.

/// What an entry costs that is given up, nats: with what speaks against the declaration at all, one alone is named from some five
/// standard deviations on, and each of several from some four.
pub const ENTRY: f64 = 5.0;
/// Rounding, as a share of an entry.
pub const ROUNDING: f64 = 1e-6;

// Entries that should be equal and are not.

/// Two entries differ by more than so many standard deviations,
pub const SURE: f64 = 4.0;
/// and by more than this share of the largest term of the force.
pub const SHARE: f64 = 0.05;
