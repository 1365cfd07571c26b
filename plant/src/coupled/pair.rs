//! A value for each of the two, and a range check.

use crate::error::RigError;

/// A value for each actuator, or for x and rotation.
pub type Pair = [f64; 2];

/// Checks that `value` is finite and in `range`.
pub(super) fn within(
    path: String,
    value: f64,
    range: std::ops::RangeInclusive<f64>,
    accepted: &str,
) -> Result<(), RigError> {
    if range.contains(&value) {
        Ok(())
    } else {
        Err(RigError::new(path, value, accepted))
    }
}
