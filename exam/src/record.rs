//! The record of a test.

/// A recorded test, uniform in time.
#[derive(Clone, Debug)]
pub struct Record {
    /// Sampling rate, Hz.
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

impl Record {
    /// A range of its samples, with their original times.
    pub(crate) fn samples(&self, range: std::ops::Range<usize>) -> Self {
        // Columns that were not recorded stay empty.
        let part = |x: &Vec<f64>| x.get(range.clone()).unwrap_or_default().to_vec();
        Self {
            rate_hz: self.rate_hz,
            time_s: part(&self.time_s),
            command_mm: part(&self.command_mm),
            displacement_mm: part(&self.displacement_mm),
            force_n: part(&self.force_n),
        }
    }
}
