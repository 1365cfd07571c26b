//! The parameters by which a laboratory describes a rig: one row per parameter.
//!
//! A declared model has a value and a tolerance for each. Code that reads, checks, fits, names or saves one uses these.

use crate::effect::{Channel, Effect};

/// A parameter of a channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChannelParameter {
    /// Its name in files, ending with its unit if it has one.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value if not declared.
    pub absent: f64,
    /// Least value that may be declared.
    pub least: f64,
    /// The name of an error of it.
    pub error: Effect,
    /// The error's parameter: with the same name a sum, with another one a fraction of the value.
    pub error_parameter: &'static str,
}

const fn parameter(
    name: &'static str,
    unit: &'static str,
    least: f64,
    error: Effect,
    error_parameter: &'static str,
) -> ChannelParameter {
    ChannelParameter {
        name,
        unit,
        absent: 0.0,
        least,
        error,
        error_parameter,
    }
}

const ANY: f64 = f64::NEG_INFINITY;

/// Command to displacement.
const ACTUATOR: [ChannelParameter; 4] = [
    ChannelParameter {
        absent: 1.0,
        ..parameter("gain", "", ANY, Effect::GainError, "error")
    },
    parameter("delay_ms", "ms", 0.0, Effect::DelayError, "delay_ms"),
    parameter("lag_ms", "ms", 0.0, Effect::LagError, "lag_ms"),
    parameter("offset_mm", "mm", ANY, Effect::Offset, "offset_mm"),
];

/// Displacement to force.
const SPECIMEN: [ChannelParameter; 4] = [
    parameter(
        "stiffness_n_per_mm",
        "N/mm",
        ANY,
        Effect::GainError,
        "error",
    ),
    parameter(
        "damping_n_s_per_mm",
        "N s/mm",
        ANY,
        Effect::ViscousDamping,
        "damping_n_s_per_mm",
    ),
    parameter("mass_kg", "kg", 0.0, Effect::InertiaForce, "mass_kg"),
    parameter("offset_n", "N", ANY, Effect::Offset, "offset_n"),
];

impl Channel {
    /// Its parameters, in the order used by fits.
    pub const fn parameters(self) -> &'static [ChannelParameter; 4] {
        match self {
            Self::Actuator => &ACTUATOR,
            Self::Specimen => &SPECIMEN,
        }
    }

    /// The names of errors of its parameters.
    pub fn mistakes(self) -> [Effect; 4] {
        self.parameters().each_ref().map(|p| p.error)
    }

    /// The parameter whose error `effect` is.
    pub fn parameter_of_error(self, effect: Effect) -> Option<usize> {
        self.parameters().iter().position(|p| p.error == effect)
    }
}

impl ChannelParameter {
    /// True if its error is a fraction of its value.
    fn is_relative(&self) -> bool {
        self.error_parameter != self.name
    }

    /// Unit of its error.
    pub fn error_unit(&self) -> &'static str {
        if self.is_relative() { "" } else { self.unit }
    }

    /// `declared` with an error.
    pub fn with_error(&self, declared: f64, error: f64) -> f64 {
        declared + error * self.per_error(declared)
    }

    /// The error of `value` relative to `declared`.
    pub fn error(&self, value: f64, declared: f64) -> f64 {
        (value - declared) / self.per_error(declared)
    }

    /// Change of the value per unit of error.
    pub fn per_error(&self, declared: f64) -> f64 {
        if self.is_relative() { declared } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_error_is_a_parameter_of_its_effect_in_its_channel() {
        for channel in Channel::ALL {
            for (i, p) in channel.parameters().iter().enumerate() {
                assert_eq!(channel.parameter_of_error(p.error), Some(i));
                let entry = p.error.entry();
                assert!(entry.channels.contains(channel), "{}", p.name);
                let of_error = |e: &&crate::effect::Parameter| e.name == p.error_parameter;
                let own = entry.parameters.iter().find(of_error).unwrap();
                assert!(own.channel.is_none_or(|c| c == *channel), "{}", p.name);
                assert_eq!(own.accept.unit, p.error_unit(), "{}", p.name);
                assert_eq!(p.error(p.with_error(-4.0, 0.5), -4.0), 0.5, "{}", p.name);
            }
        }
    }
}
