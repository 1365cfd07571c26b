//! Thresholds on records before anything is fitted, each with its reason.

// Records that cannot be of the declared rig.

/// Factor beyond which a ratio indicates wrong units.
pub const SLIP: f64 = 250.0;
/// A force drives the motion if its work is below this fraction of that of the same force always resisting: a damper
/// has all of that work, a spring or a mass none; a spring that is read late by an eighth of a period gives 0.88 of it.
pub const GIVES: f64 = -0.95;
/// Fewest samples of all training records together, and of all test records.
pub const FEWEST_IN_ALL: usize = 200;
/// A record is too slow for an actuator if its delay and lag are over within this fraction of an interval.
pub const OVER: f64 = 0.1;
/// Samples that stay at an end to the bit for this long are one stop there.
pub const STOP: usize = 10;
/// Number of stops that indicate a rail; a single one may be a rest at an end.
pub const STOPS: usize = 3;
/// Fraction of the drive's return during a stop by which it must first have gone on.
pub const GOES_ON: f64 = 0.15;
/// The same, as a fraction of the drive's whole range: less is its noise during a hold.
pub const GOES_FAR: f64 = 0.02;
/// Fraction of the spring's force from which a declared mass may reverse the sign of the total.
pub const HEAVY: f64 = 0.3;

// Errors in a record.

/// Tolerance of a ratio relative to a factor between two units: the error that a declared value may have.
pub const NEAR: f64 = 0.06;
/// Smallest correlation of channels that belong together.
pub const FOLLOWS: f64 = 0.8;
/// A channel is dead if it is constant to the bit for this long, s,
pub const DEAD_S: f64 = 0.5;
/// while its input moves by this fraction of its range.
pub const MOVES: f64 = 0.3;
/// A single sample is an outlier if it deviates from its neighbours by this multiple of what nine tenths of samples do,
pub const LEAVES: f64 = 20.0;
/// and by this fraction of the channel's range,
pub const FAR: f64 = 0.02;
/// while its neighbours differ from each other by at most this fraction of that.
pub const BACK: f64 = 0.3;
/// Fewest outliers that are no coincidence.
pub const FEWEST_OUTLIERS: usize = 3;
