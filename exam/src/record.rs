//! What a test leaves behind.

/// A recorded test, uniform in time.
#[derive(Clone, Debug)]
pub struct Record {
    /// Samples a second.
    pub rate_hz: f64,
    /// s
    pub time_s: Vec<f64>,
    /// mm
    pub command_mm: Vec<f64>,
    /// mm
    pub displacement_mm: Vec<f64>,
    /// N
    pub force_n: Vec<f64>,
}
