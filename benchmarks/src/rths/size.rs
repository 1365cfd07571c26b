//! How large and how fast the problem is.

/// Sampling rate of the problem, Hz.
pub const RATE_HZ: f64 = 4096.0;
/// Floors of the structure.
pub const FLOORS: usize = 3;
