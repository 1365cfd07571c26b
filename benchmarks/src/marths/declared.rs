//! What the declared physical part costs even a tracker without any error.
//!
//! Such a tracker still has a J7 of 10 % and 8 %, because the part that is subtracted as physical is not the frame that really
//! responds. A diagnosis of the loop's own record (see [`record`]) finds the real one; subtracting that instead lowers the floor.

use super::SIGN;
use super::criteria::{Both, deviation};
use super::structure::{FrameMatrices, PhysicalMatrices};
use super::trial::{MarthsTrace, computed, without_error};
use crate::Refused;
use schemars::JsonSchema;
use serde::Serialize;

/// What is subtracted as physical, and what a tracker without any error then has for J7.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct Floor {
    /// What is subtracted.
    pub subtracted: &'static str,
    /// J7 of x and rotation, per cent.
    #[serde(rename = "J7")]
    pub j7: Both,
}

/// J7 of a tracker without any error.
///
/// # Errors
/// A structure that cannot be integrated.
pub fn floor(
    reference: &FrameMatrices,
    part: &PhysicalMatrices,
    ground: &[f64],
) -> Result<Both, Refused> {
    let exact = computed(reference, ground)?;
    let tracked = without_error(&reference.less(part), ground)?;
    let column = |t: &MarthsTrace, i: usize| t.numerical.iter().map(|p| p[i]).collect::<Vec<_>>();
    Ok([0, 1].map(|i| deviation(&column(&tracked, i), &column(&exact, i))))
}

/// The coordinates of a [`PhysicalMatrices`], under the names that records and models use.
pub const COORDINATES: [&str; 3] = ["x_m", "free_rotation_rad", "rotation_rad"];

/// One coordinate of a part during the test, in the structure's sign.
#[derive(Clone, Debug, PartialEq)]
pub struct Coordinate {
    /// Its target from the numerical part, m or rad.
    pub target: Vec<f64>,
    /// Its reading, m or rad.
    pub displacement: Vec<f64>,
    /// The force that the numerical part gets from the laboratory, N or N m.
    pub force: Vec<f64>,
}

/// The record of a trial, in the order of [`COORDINATES`]. The free rotation is taken from the numerical part: nothing in the
/// laboratory moves it, and no force comes from it.
pub fn record(trace: &MarthsTrace) -> [Coordinate; 3] {
    let column = |pairs: &[Both], i: usize, sign: f64| -> Vec<f64> {
        pairs.iter().map(|p| sign * p[i]).collect()
    };
    let controlled = |i: usize, sign: f64| Coordinate {
        target: column(&trace.numerical, i, sign),
        displacement: column(&trace.interface, i, sign),
        force: column(&trace.force, i, sign),
    };
    [
        controlled(0, 1.0),
        Coordinate {
            target: trace.free_rotation.clone(),
            displacement: trace.free_rotation.clone(),
            force: vec![0.0; trace.free_rotation.len()],
        },
        controlled(1, SIGN),
    ]
}
