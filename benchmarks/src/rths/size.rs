//! Size and sampling rate of the problem.

/// Sampling rate of the problem, Hz.
pub const RATE_HZ: f64 = 4096.0;
/// Number of floors.
pub const FLOORS: usize = 3;
