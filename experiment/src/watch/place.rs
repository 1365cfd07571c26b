//! Where a test is watched.

use crate::trace::Response;

/// Where a test is watched.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// What the motion is planned to be.
    pub ideal: &'a Response,
    /// First natural frequency, Hz of the model.
    pub first_hz: f64,
    /// Length of the test, s of the model.
    pub seconds: f64,
}
