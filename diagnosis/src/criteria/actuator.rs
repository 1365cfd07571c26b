//! Thresholds of the actuator's joint search, each with its reason.

use super::WORTH_A_NAME;

// What a model with elements must reach.

/// Up to so much of a noise that a rest has told, beside it, nothing is missing.
pub const TO_THE_NOISE: f64 = 0.5;
/// The same for a noise that is read off the motion itself.
pub const ABOUT_THE_NOISE: f64 = 1.3;
/// What explains less than this share of the squares is [`WORTH_A_NAME`] of the error at most.
pub const LITTLE: f64 = 1.0 - (1.0 - WORTH_A_NAME) * (1.0 - WORTH_A_NAME);
/// What leaves no more than this share of the held-out error accounts for the record.
pub const ACCOUNTS: f64 = 0.3;
/// A noise may be so many times what is reached by chance.
pub const BY_CHANCE: f64 = 1.1;

// Samples that are searched.

/// Samples that a search makes do with.
pub const SEARCHED: usize = 4000;
/// Samples a cycle of the band's end that averaging leaves, and that it leaves where there would be too many.
pub const A_CYCLE: [f64; 2] = [20.0, 12.0];
/// More samples than these are too many.
pub const TOO_MANY: usize = 8000;
/// No more of a record than this share only settles the model.
pub const MOST_SETTLING: f64 = 0.05;

// Rivals.

/// Rivals of a name that are fitted.
pub const RIVALS: usize = 4;
