//! A method as a linear system, for reports on stability. Nothing of it runs in a step, so it is in f64.
//!
//! A fixed predictor is linear. An adaptive one is not; it is replaced by its law with fixed parameters, either those
//! declared to it ([`Setting::declared`]) or those it has learnt ([`Setting::learnt`]): the parameters that bring this
//! rig to the target at one frequency, within the law's bounds. While it learns it is neither. Each method has its
//! linear form in its own file; the report decides what to make of it.

use crate::config::{Compensation, Config};

/// A sum of the motion ahead and of what came of the last command. Factors are in powers of a control step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sum {
    /// Of the next target.
    pub displacement: f64,
    /// Of its velocity.
    pub velocity: f64,
    /// Of its acceleration.
    pub acceleration: f64,
    /// Of the change of its acceleration in a control step.
    pub jerk: f64,
    /// Of the next target less the one in force.
    pub rise: f64,
    /// Of the tracking error, the target in force less the measured displacement.
    pub error: f64,
    /// Of the low-passed tracking error, and what the low-pass takes of a new one.
    pub feedback: [f64; 2],
}

impl Sum {
    /// The next target as it is.
    pub const TARGET: Self = Self {
        displacement: 1.0,
        velocity: 0.0,
        acceleration: 0.0,
        jerk: 0.0,
        rise: 0.0,
        error: 0.0,
        feedback: [0.0; 2],
    };

    /// `u + a_1 v + a_2 a + a_3 j` with factors in powers of a second.
    pub(crate) fn inverse([first, second, third]: [f64; 3], rate_hz: f64) -> Self {
        Self {
            velocity: first * rate_hz,
            acceleration: second * rate_hz * rate_hz,
            jerk: third * rate_hz * rate_hz * rate_hz,
            ..Self::TARGET
        }
    }

    /// Factors of displacement and velocity that have to be added so that the frequency response at `omega` is
    /// `wanted`.
    pub(crate) fn missing(&self, wanted: FrequencyResponse, omega: f64) -> [f64; 2] {
        let square = omega * omega;
        let real = self.displacement - square * self.acceleration;
        let per_omega = self.velocity - square * self.jerk;
        [wanted.real - real, wanted.imaginary / omega - per_omega]
    }
}

/// A predictor as a linear system in control steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Linear {
    /// A sum of the motion.
    Sum(Sum),
    /// Weights of the target now, and one, two and three delays ago.
    Extrapolation {
        /// The weights.
        weights: [f64; 4],
        /// The delay, control steps.
        delay: f64,
    },
    /// `new x + last x_1 + memory y_1`, with `x` the targets and `y` the commands.
    Lead {
        /// `[new, last, memory]`.
        weights: [f64; 3],
    },
    /// Where a free vibration of the declared structure takes velocity and acceleration in `delay_s` of model time.
    FreeVibration {
        /// The delay, s of model time.
        delay_s: f64,
    },
}

/// What a force law comes to over a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinearForce {
    /// The measured force.
    Measured,
    /// The force at the target: the stiffness times the way that is left.
    AtTarget,
    /// Of that the part that is in phase with the velocity, as a damping of the axis between these multiples of the
    /// declared stiffness times the declared delay; `None` without bounds.
    Damping {
        /// The bounds.
        within: Option<[f64; 2]>,
    },
}

/// Command over target that brings a rig to the target at one frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyResponse {
    /// Real part.
    pub real: f64,
    /// Imaginary part; positive where the command leads.
    pub imaginary: f64,
}

impl FrequencyResponse {
    /// Its amplitude.
    pub(crate) fn gain(self) -> f64 {
        libm::hypot(self.real, self.imaginary)
    }

    /// Its phase, rad.
    pub(crate) fn phase(self) -> f64 {
        libm::atan2(self.imaginary, self.real)
    }
}

/// The test in which a predictor stands, and what its law knows.
#[derive(Debug)]
pub struct Setting<'a> {
    config: &'a Config,
    actuator: usize,
    learnt: Option<(FrequencyResponse, f64)>,
    at_bounds: bool,
}

impl<'a> Setting<'a> {
    /// A law with the parameters that were declared to it, of an actuator from 0.
    pub fn declared(config: &'a Config, actuator: usize) -> Self {
        Self {
            config,
            actuator,
            learnt: None,
            at_bounds: false,
        }
    }

    /// A law that has learnt to answer with `wanted` at `omega` (rad per control step).
    pub fn learnt(
        config: &'a Config,
        actuator: usize,
        wanted: FrequencyResponse,
        omega: f64,
    ) -> Self {
        Self {
            learnt: Some((wanted, omega)),
            ..Self::declared(config, actuator)
        }
    }

    /// The law would have to learn more than its bounds allow.
    pub fn at_bounds(&self) -> bool {
        self.at_bounds
    }

    pub(crate) fn compensation(&self) -> &'a Compensation {
        &self.config.compensation
    }

    /// Declared stiffness of the lowest storey, N/m.
    pub(crate) fn stiffness_n_per_m(&self) -> f64 {
        let storeys = &self.config.structure.stiffness_n_per_m;
        storeys.first().copied().unwrap_or(0.0)
    }

    pub(crate) fn rate_hz(&self) -> f64 {
        self.config.timing.rate_hz
    }

    /// The declared delay, ms.
    pub(crate) fn delay_ms(&self) -> f64 {
        self.compensation().delay_ms.at(self.actuator)
    }

    /// The declared delay, control steps.
    pub(crate) fn delay_steps(&self) -> f64 {
        self.delay_ms() * 1e-3 * self.rate_hz()
    }

    /// The declared delay, s of model time.
    pub(crate) fn model_delay_s(&self) -> f64 {
        self.delay_ms() * 1e-3 / self.config.timing.time_scale
    }

    /// The inverse of the actuator, in powers of a second.
    pub(crate) fn inverse(&self) -> [f64; 3] {
        self.compensation().inverse(self.actuator)
    }

    /// Required frequency response and its frequency, rad per control step; `None` where nothing has been learnt.
    pub(crate) fn wanted(&self) -> Option<(FrequencyResponse, f64)> {
        self.learnt
    }

    /// A parameter within the bounds of its law.
    pub(crate) fn bounded(&mut self, value: f64, low: f64, high: f64) -> f64 {
        self.at_bounds |= !(low..=high).contains(&value);
        value.clamp(low, high)
    }

    /// Longest delay that may be learnt, control steps.
    pub(crate) fn longest_steps(&self) -> f64 {
        let longest_ms = self.compensation().adaptation.longest_delay_ms;
        longest_ms.max(self.delay_ms()) * 1e-3 * self.rate_hz()
    }

    /// A learnt delay, control steps.
    pub(crate) fn delay(&mut self, steps: f64) -> f64 {
        let longest = self.longest_steps();
        self.bounded(steps, 0.0, longest)
    }

    /// A learnt gain.
    pub(crate) fn gain(&mut self, gain: f64) -> f64 {
        let tolerance = self.compensation().adaptation.gain_tolerance;
        self.bounded(gain, 1.0 - tolerance, 1.0 + tolerance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Config;
    use crate::method::Prediction;

    /// What a law has learnt responds as required, and a requirement beyond its bounds is reported.
    #[test]
    fn a_law_that_has_learnt_answers_as_wanted_or_is_at_its_bounds() {
        let mut config = Config::shear_frame([1000.0], [158e3], [0.02]);
        config.compensation.delay_ms = 4.0.into();
        let omega: f64 = 0.006;
        let answer = |gain: f64, phase: f64| FrequencyResponse {
            real: gain * libm::cos(phase),
            imaginary: gain * libm::sin(phase),
        };
        // Eleven control steps are 5.5 ms.
        let wanted = answer(1.0, 11.0 * omega);
        for predictor in [Prediction::Afp, Prediction::Ats, Prediction::Amb] {
            assert!(predictor.learns());
            let mut setting = Setting::learnt(&config, 0, wanted, omega);
            let Linear::Sum(sum) = predictor.linear(&mut setting) else {
                panic!("{} is a sum", predictor.name());
            };
            let left = sum.missing(wanted, omega);
            assert!(left[0].abs() < 1e-4 && left[1].abs() < 1e-2, "{left:?}");
            assert!(!setting.at_bounds(), "{}", predictor.name());
        }
        let far = answer(1.0, 0.9);
        for predictor in [Prediction::Darby, Prediction::Afp, Prediction::Ats] {
            let mut slow = Setting::learnt(&config, 0, far, 0.001);
            predictor.linear(&mut slow);
            assert!(slow.at_bounds(), "{}: 900 control steps", predictor.name());
        }
    }
}
