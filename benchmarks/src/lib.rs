#![doc = include_str!("../README.md")]
//!
//! # Map
//!
//! | look in | for |
//! |---|---|
//! | [`rths`] | one actuator, a three-storey frame (Silva et al. 2020) |
//! | [`marths`] | two coupled actuators, a frame of 29 degrees of freedom (Condori Uribe et al. 2023) |
//! | [`linear`] | linear systems over a sampling period, exactly |

pub mod linear;
pub mod marths;
pub mod rths;

/// Why a benchmark cannot run: one sentence that names what, where and which value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused(String);

impl Refused {
    /// Makes one from its sentence.
    pub fn new(sentence: impl Into<String>) -> Self {
        Self(sentence.into())
    }
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Refused {}
