//! One sentence for a parameter that cannot be accepted.

use core::fmt;

/// A refused parameter: its name as in the test file, its value, and what would be accepted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refusal {
    /// Path of the parameter, e.g. `loop.rate_hz`.
    pub name: &'static str,
    /// The value that was given.
    pub value: f64,
    /// What would be accepted.
    pub accepted: &'static str,
}

/// The accepted values, if no single value is wrong.
const SOLVABLE: &str = "masses that leave a symmetric positive definite matrix";

impl Refusal {
    /// A matrix or mass that leaves the equation of motion without a solution.
    pub(crate) const fn matrix(name: &'static str) -> Self {
        Self {
            name,
            value: f64::NAN,
            accepted: SOLVABLE,
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.accepted == SOLVABLE {
            write!(
                f,
                "{} is refused: accepted are {}",
                self.name, self.accepted
            )
        } else if self.value.abs() >= 1e15 {
            // Fifteen zeros are not readable.
            write!(
                f,
                "{} = {:e} is refused: accepted are {}",
                self.name, self.value, self.accepted
            )
        } else {
            write!(
                f,
                "{} = {} is refused: accepted are {}",
                self.name, self.value, self.accepted
            )
        }
    }
}

impl core::error::Error for Refusal {}

/// Accepts `value` if `ok` holds; a NaN is never accepted.
///
/// # Errors
/// The refusal, with the name and the value.
pub fn accept(
    name: &'static str,
    value: f64,
    ok: bool,
    accepted: &'static str,
) -> Result<(), Refusal> {
    if ok && !value.is_nan() {
        Ok(())
    } else {
        Err(Refusal {
            name,
            value,
            accepted,
        })
    }
}

/// Accepts `value` strictly between `above` and `below`.
///
/// # Errors
/// The refusal, with the name and the value.
pub fn between(
    name: &'static str,
    value: f64,
    above: f64,
    below: f64,
    accepted: &'static str,
) -> Result<(), Refusal> {
    accept(name, value, value > above && value < below, accepted)
}
