//! Thresholds on an answer about a specimen, each with its reason.

// What stands at corners of the motion.

/// A corner: the acceleration between a cut-off and twice that is this multiple of its noise, which normal noise is once
/// in two thousand samples.
pub const CORNER: f64 = 3.5;
/// What a model leaves stands at corners if it is this multiple of what it leaves elsewhere.
pub const LEFT_AT_CORNERS: f64 = 2.0;
/// If corners exceed this fraction of the motion, they are the motion itself.
pub const MOST_CORNERS: f64 = 0.5;
/// The same for held-out data, which only judge.
pub const MOST_CORNERS_HELD_OUT: f64 = 0.75;

// Stiffness lost for good.

/// Largest deviation from an even pace of a motion that counts as even, as a fraction of its travel: pauses and cycles
/// of different sizes tell travel from time.
pub const EVEN: f64 = 0.05;
/// Squared correlation from which two causes of a loss grow as one.
pub const TOGETHER: f64 = 0.9;

// Springs.

/// A motion has been on both sides of zero if it crosses it by this fraction of half its range: below this a
/// transducer's zero error is as likely as the specimen's.
pub const BOTH_SIDES: f64 = 0.25;
