//! Thresholds on records before anything is fitted, each with its reason.

// Records that cannot be of the declared rig.

/// Factor beyond which a proportion is a slip of units.
pub const SLIP: f64 = 250.0;
/// A force whose work is less than this share of what it would take that always resisted drives the motion: a damper takes
/// all, a spring and a mass take nothing; a spring that is read late by an eighth of a period gives 0.88 of it.
pub const GIVES: f64 = -0.95;
/// The fewest samples of all training records, and of all test records, together.
pub const FEWEST_IN_ALL: usize = 200;
/// A record of an actuator is too slow where its delay and lag are over within this share of an interval.
pub const OVER: f64 = 0.1;
/// Samples that stay at an end to the bit for so long are one stop there.
pub const STOP: usize = 10;
/// So many stops are a rail; a rest at one end is one.
pub const STOPS: usize = 3;
/// Of what the driving signal moves during a stop: the share by which it must go on and come back.
pub const GOES_ON: f64 = 0.15;
/// The same of its whole range: less is its noise while everything holds.
pub const GOES_FAR: f64 = 0.02;
/// Share of the spring's force from which on a declared mass may turn the sign of the whole.
pub const HEAVY: f64 = 0.3;

// Mistakes in a record.

/// How near a ratio must be to the factor between two units, as a share of it: what a declared value may be off.
pub const NEAR: f64 = 0.06;
/// Channels that belong together follow each other at least so well.
pub const FOLLOWS: f64 = 0.8;
/// A channel is dead that stays the same to the bit for so long, s,
pub const DEAD_S: f64 = 0.5;
/// while its input moves by this share of its range.
pub const MOVES: f64 = 0.3;
/// A single sample leaves its neighbours by so many times what nine tenths of all samples leave theirs by,
pub const LEAVES: f64 = 20.0;
/// and by this share of the channel's range,
pub const FAR: f64 = 0.02;
/// while its neighbours differ from each other by at most this share of that.
pub const BACK: f64 = 0.3;
/// So many of them are no chance.
pub const FEWEST_OUTLIERS: usize = 3;
