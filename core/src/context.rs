//! What a part of the loop may know when its constants are worked out. Configuration only: f64.

use crate::config::Compensation;
use crate::matrix::Matrix;
use crate::structure::Structure;

/// The test around a method.
#[derive(Debug)]
pub(crate) struct Context<'a, const N: usize> {
    /// `[compensation]`, with the parameters of all methods.
    pub parameters: &'a Compensation,
    /// The structure of the equation of motion.
    pub structure: &'a Structure<N>,
    /// Declared stiffness of the specimen, N/m.
    pub specimen_n_per_m: Matrix<N>,
    /// Natural frequencies, rad/s of model time, ascending.
    pub omega: [f64; N],
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Laboratory time per model time.
    pub time_scale: f64,
    /// Integration step, s of model time.
    pub model_step_s: f64,
}

impl<const N: usize> Context<'_, N> {
    /// The declared delay of the actuator, control steps.
    pub fn delay_steps(&self) -> f64 {
        self.parameters.delay_ms * 1e-3 * self.rate_hz
    }

    /// The declared delay of the actuator, s of model time.
    pub fn model_delay_s(&self) -> f64 {
        self.parameters.delay_ms * 1e-3 / self.time_scale
    }

    /// What a running peak of the motion keeps from one integration step to the next: it fades within a natural period.
    pub fn peak_memory(&self) -> f32 {
        libm::exp(-self.omega[0] * self.model_step_s / core::f64::consts::TAU) as f32
    }

    /// Number of axes in the laboratory.
    pub fn physical(&self) -> usize {
        self.structure.physical.min(N)
    }
}
