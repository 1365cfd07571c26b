//! Thresholds on an answer about a specimen, each with its reason.

// What is left at corners of the motion alone.

/// A corner: the forces of damping and mass change by so many times what noise changes them by, which normal noise does once in
/// two thousand samples.
pub const CORNER: f64 = 3.5;
/// More corners than this share of the motion are the motion itself.
pub const MOST_CORNERS: f64 = 0.35;

// Stiffness that is lost for good.

/// By so much of the whole way, at most, is a motion ahead of an even pace or behind it that has one: pauses and cycles of
/// another size are what tells travel from time.
pub const EVEN: f64 = 0.05;
/// The square of the correlation from which on two causes of a loss grow as one.
pub const TOGETHER: f64 = 0.9;

// Springs.

/// A motion that goes to the other side of zero by so much of half its range has been on both sides of it: below this a
/// transducer's zero is as likely as the specimen's.
pub const BOTH_SIDES: f64 = 0.25;
