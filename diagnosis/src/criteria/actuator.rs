//! What an actuator's records are searched by, each with its reason.

/// A noise may be so many times what is reached by chance.
pub const BY_CHANCE: f64 = 1.1;

/// Samples that a search makes do with.
pub const SEARCHED: usize = 4000;
/// Samples a cycle of the band's end that averaging leaves, and that it leaves where there would be too many.
pub const A_CYCLE: [f64; 2] = [20.0, 12.0];
/// More samples than these are too many.
pub const TOO_MANY: usize = 8000;
/// No more of a record than this share only settles the model.
pub const MOST_SETTLING: f64 = 0.05;
