//! Thresholds of the search among matrices of several coordinates, each with its reason.

// Entries that are named.

/// The distance must fall by so much for an entry to be named: four standard deviations.
pub const NAMED: f64 = 16.0;
/// Another entry that leaves so little more explains the record as well.
pub const AS_WELL: f64 = 6.0;
/// Rounding, as a share of an entry.
pub const ROUNDING: f64 = 1e-6;

// Entries that should be equal and are not.

/// Two entries differ by more than so many standard deviations,
pub const SURE: f64 = 4.0;
/// and by more than this share of the largest term of the force.
pub const SHARE: f64 = 0.05;
