//! The inputs available to a part of the loop when its constants are computed. Configuration only: f64.

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
    /// The test as an actuator sees it, from 0; an axis without one has the last one's delay.
    pub fn actuator(&self, j: usize) -> ActuatorContext<'_> {
        let j = j.min(self.physical().saturating_sub(1));
        ActuatorContext {
            parameters: self.parameters,
            delay_ms: self.parameters.delay_ms.at(j),
            inverse: self.parameters.inverse(j),
            stiffness_n_per_m: self.specimen_n_per_m[0][0],
            omega: self.omega[0],
            rate_hz: self.rate_hz,
            time_scale: self.time_scale,
            model_step_s: self.model_step_s,
        }
    }

    /// The declared delay of an actuator, from 0, s of model time.
    pub fn model_delay_s(&self, j: usize) -> f64 {
        self.actuator(j).delay_ms * 1e-3 / self.time_scale
    }

    /// Decay factor of a running peak of the motion per integration step: it fades within a natural period.
    pub fn peak_memory(&self) -> f32 {
        libm::exp(-self.omega[0] * self.model_step_s / core::f64::consts::TAU) as f32
    }

    /// Number of axes in the laboratory.
    pub fn physical(&self) -> usize {
        self.structure.physical.min(N)
    }
}

/// What a method may know of one actuator and its axis. Not generic over the number of floors, so that an image holds each
/// design once.
#[derive(Debug)]
#[non_exhaustive]
pub struct ActuatorContext<'a> {
    /// `[compensation]`, with the parameters of all methods.
    pub parameters: &'a Compensation,
    /// The declared delay, ms.
    pub delay_ms: f64,
    /// The inverse of the actuator, in powers of a second.
    pub inverse: [f64; 3],
    /// Declared stiffness of the specimen at the lowest floor, N/m.
    pub stiffness_n_per_m: f64,
    /// First natural frequency, rad/s of model time.
    pub omega: f64,
    /// Control rate, Hz.
    pub rate_hz: f64,
    /// Laboratory time per model time.
    pub time_scale: f64,
    /// Integration step, s of model time.
    pub model_step_s: f64,
}

impl ActuatorContext<'_> {
    /// The declared delay, control steps.
    pub fn delay_steps(&self) -> f64 {
        self.delay_ms * 1e-3 * self.rate_hz
    }
}
