//! What a part of the loop may know when its constants are worked out. Configuration only: f64.

use crate::config::Compensation;
use crate::matrix::Matrix;
use crate::structure::Structure;

/// The test around a method.
#[derive(Clone, Copy, Debug)]
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
    /// The actuator whose times are asked for, from 0.
    pub actuator: usize,
}

impl<const N: usize> Context<'_, N> {
    /// The same test as another actuator sees it; what has none is as the last one.
    pub fn of(&self, actuator: usize) -> Self {
        Self {
            actuator: actuator.min(self.physical().saturating_sub(1)),
            ..*self
        }
    }

    /// The declared delay of the actuator, ms.
    pub fn delay_ms(&self) -> f64 {
        self.parameters.delay_ms.at(self.actuator)
    }

    /// The declared delay of the actuator, control steps.
    pub fn delay_steps(&self) -> f64 {
        self.delay_ms() * 1e-3 * self.rate_hz
    }

    /// The declared delay of the actuator, s of model time.
    pub fn model_delay_s(&self) -> f64 {
        self.delay_ms() * 1e-3 / self.time_scale
    }

    /// The inverse of the actuator, in powers of a second.
    pub fn inverse(&self) -> [f64; 3] {
        self.parameters.inverse(self.actuator)
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
