//! Thresholds of the search in an actuator's records, each with its reason.

/// Ratio of a stated noise to the error reached that may be chance.
pub const BY_CHANCE: f64 = 1.1;

/// Number of samples sufficient for a search.
pub const SEARCHED: usize = 4000;
/// Samples per cycle of the band's end after averaging, and after averaging if there would be too many samples.
pub const A_CYCLE: [f64; 2] = [20.0, 12.0];
/// More samples than this are too many.
pub const TOO_MANY: usize = 8000;
/// Largest fraction of a record that may only settle the model.
pub const MOST_SETTLING: f64 = 0.05;
