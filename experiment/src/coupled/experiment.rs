//! A test of two coupled actuators and what shakes it.

use super::file::CoupledTest;
use crate::experiment::LaidOutShaking;
use crate::failure::Failure;
use outerloop_core::GroundMotion;

/// A test and what shakes it.
#[derive(Clone, Debug)]
pub struct CoupledExperiment {
    /// What is tested.
    pub test: CoupledTest,
    /// Name of the ground motion.
    pub record: String,
    /// What is laid under the test.
    pub shaken: LaidOutShaking,
    /// Factor on the ground motion.
    pub scale: f64,
}

impl CoupledExperiment {
    /// Control steps of the running test.
    pub fn steps(&self) -> usize {
        (self.shaken.seconds * self.test.timing.rate_hz).round() as usize
    }

    /// What shakes the structure, step by step.
    ///
    /// # Errors
    /// An interval that cannot be laid over the steps.
    pub fn ground(&self) -> Result<GroundMotion<'_>, Failure> {
        let period_s = self.test.period_s();
        let interval_s = self.shaken.interval_s;
        GroundMotion::new(&self.shaken.acc_m_per_s2, interval_s, period_s).ok_or_else(|| {
            Failure::input(format!(
                "{}: an interval of {interval_s} s cannot be laid over steps of {period_s} s",
                self.record
            ))
        })
    }
}
