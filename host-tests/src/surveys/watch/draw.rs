//! Random draws.

use plant::random::{Normal, Purpose};

/// Random numbers for one test, always the same for the same seed.
pub(super) struct Draw(Normal);

impl Draw {
    pub(super) fn new(seed: u64) -> Self {
        Self(Normal::new(seed, Purpose::DrawnPlant, 26))
    }

    /// Uniform between two bounds.
    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        0.5 * (low + high) + self.0.even(0.5 * (high - low))
    }

    /// Log-uniform between two bounds.
    pub(super) fn ratio(&mut self, low: f64, high: f64) -> f64 {
        self.between(low.ln(), high.ln()).exp()
    }

    /// Uniform within a tolerance either way.
    pub(super) fn off(&mut self, tolerance: f64) -> f64 {
        self.between(-tolerance, tolerance)
    }

    pub(super) fn of<'a, T: ?Sized>(&mut self, list: &[&'a T]) -> &'a T {
        let at = self.between(0.0, list.len() as f64) as usize;
        list[at.min(list.len() - 1)]
    }

    pub(super) fn sign(&mut self) -> f64 {
        self.0.even(1.0).signum()
    }

    /// Normal, with standard deviation 1.
    pub(super) fn normal(&mut self) -> f64 {
        self.0.sample()
    }
}
