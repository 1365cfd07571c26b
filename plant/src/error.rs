//! Refusals: where, which value, and what would be accepted.

use std::fmt;

/// A rig that cannot be built as specified.
#[derive(Clone, Debug, PartialEq)]
pub struct RigError {
    /// Path of the value in the test file, e.g. `plant.actuator.delay_ms`.
    pub path: String,
    /// The value found there.
    pub value: String,
    /// What would be accepted.
    pub accepted: String,
}

impl RigError {
    /// `path` holds `value`, which is not one of `accepted`.
    pub fn new(
        path: impl Into<String>,
        value: impl fmt::Display,
        accepted: impl Into<String>,
    ) -> Self {
        Self {
            path: path.into(),
            value: value.to_string(),
            accepted: accepted.into(),
        }
    }
}

/// Refuses the first parameter that the kind of `part` does not have: a parameter without effect is a mistake. Each has its name,
/// whether it is given beside another kind, and the kinds that have it.
pub(crate) fn refuse_stray(part: &str, all: &[(&str, bool, &str)]) -> Result<(), RigError> {
    match all.iter().find(|(_, is_stray, _)| *is_stray) {
        None => Ok(()),
        Some((name, _, kinds)) => Err(RigError::new(
            format!("plant.{part}.{name}"),
            "given",
            format!("it beside plant.{part}.kind = {kinds} only"),
        )),
    }
}

impl fmt::Display for RigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            path,
            value,
            accepted,
        } = self;
        write!(f, "{path} is {value}, accepted is {accepted}")
    }
}

impl std::error::Error for RigError {}

/// A closed range of accepted numbers with its unit (empty: none).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accept {
    /// Least accepted value.
    pub min: f64,
    /// Greatest accepted value.
    pub max: f64,
    /// Unit, for the message.
    pub unit: &'static str,
}

impl Accept {
    /// From `min` to `max`.
    pub const fn new(min: f64, max: f64, unit: &'static str) -> Self {
        Self { min, max, unit }
    }

    /// Returns the value itself if it lies inside.
    pub fn check(&self, path: &str, value: f64) -> Result<f64, RigError> {
        if value >= self.min && value <= self.max {
            Ok(value)
        } else {
            Err(RigError::new(path, value, self.to_string()))
        }
    }
}

impl fmt::Display for Accept {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a number from {} to {}", self.min, self.max)?;
        if !self.unit.is_empty() {
            write!(f, " {}", self.unit)?;
        }
        Ok(())
    }
}
