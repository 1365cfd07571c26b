//! A number that a laboratory declares.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A declared parameter. The fit may move it by three tolerances; beyond that the change is reported as an effect.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Declared {
    /// Value, in the unit of the parameter's name.
    pub value: f64,
    /// One standard tolerance, absolute.
    pub tolerance: f64,
}

/// Beyond it nothing is declared at all, in whatever unit.
pub(crate) const LARGEST_TOLERANCE: f64 = 1e9;
