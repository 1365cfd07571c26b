//! The figures specific to a test of two coupled actuators.

use super::interface::InterfaceScore;
use super::part::CoupledPart;
use super::settings::{NAMED, plant_of};
use super::table::CoupledCompensation;
use outerloop_core::Trip;
use outerloop_core::coupled::{INTERFACE_AXIS, Plant};
use schemars::JsonSchema;
use serde::Serialize;

/// The name of a fault's axis: an actuator, or a coordinate of the interface.
pub fn axis_name(axis: u8) -> Option<&'static str> {
    const ROTATION: u8 = INTERFACE_AXIS + 1;
    Some(match axis {
        0 => "actuator 1",
        1 => "actuator 2",
        INTERFACE_AXIS => "x",
        ROTATION => "rotation",
        _ => return None,
    })
}

/// A number of the actuators: what was declared, what the test found, what the simulated rig has.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct FoundNumber {
    /// Its key in `[coupled.actuators]`.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// As declared.
    pub declared: f32,
    /// As found in the end.
    pub found: f32,
    /// Of the simulated rig.
    pub simulated: f32,
}

/// Figures in addition to those of other tests.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct CoupledFigures {
    /// What tripped: an actuator, x or the rotation.
    pub trip_axis: Option<&'static str>,
    /// Names of the coordinates.
    pub coordinates: Vec<String>,
    /// Eq 17, coordinate by coordinate.
    pub eps_max_by_coordinate: Vec<f64>,
    /// Eq 18, coordinate by coordinate.
    pub eps_rms_by_coordinate: Vec<f64>,
    /// Root mean square of true stroke minus target, relative to that of the target, by actuator; on a board of the measured
    /// stroke.
    pub tracking_rms_by_actuator: [f64; 2],
    /// Largest rotation of the interface, rad.
    pub peak_rotation_rad: f64,
    /// Largest force of each actuator, N.
    pub peak_actuator_force_n: [f64; 2],
    /// What was found out about the actuators; empty if nothing is estimated.
    pub found: Vec<FoundNumber>,
}

impl CoupledFigures {
    /// For a test with this `score` and the errors of its coordinates by Eqs 17 and 18; `actuators` is the loop's final
    /// estimate of them.
    pub(crate) fn of(
        part: &CoupledPart,
        score: &InterfaceScore,
        (eps_max, eps_rms): (&[f64], &[f64]),
        trip: Option<Trip>,
        actuators: Option<Plant>,
    ) -> Self {
        Self {
            trip_axis: trip.and_then(|t| axis_name(t.axis)),
            coordinates: part.declared.structure.coordinates.clone(),
            eps_max_by_coordinate: eps_max.to_vec(),
            eps_rms_by_coordinate: eps_rms.to_vec(),
            tracking_rms_by_actuator: score.tracking_rms(),
            peak_rotation_rad: score.peak_rotation_rad,
            peak_actuator_force_n: score.peak_actuator_force_n,
            found: actuators.map_or_else(Vec::new, |found| found_numbers(part, &found)),
        }
    }

    /// The unit of a value of `trip`: its fault's `unit`, converted for a rotation.
    pub(crate) fn unit_of(trip: Trip) -> &'static str {
        match (axis_name(trip.axis), trip.fault.unit()) {
            (Some("rotation"), "m") => "rad",
            (Some("rotation"), "m/s") => "rad/s",
            (Some("rotation"), "N") => "N m",
            (_, unit) => unit,
        }
    }
}

/// The estimates, with the declared values and those of the simulated rig.
fn found_numbers(part: &CoupledPart, found: &Plant) -> Vec<FoundNumber> {
    if part.declared.compensation != CoupledCompensation::Coupled || part.rig.ideal {
        return Vec::new();
    }
    let (declared, simulated) = (
        plant_of(&part.declared.actuators),
        plant_of(&part.rig.actuators),
    );
    let numbers = NAMED.into_iter().map(|(name, unit, of)| FoundNumber {
        name,
        unit,
        declared: of(&declared),
        found: of(found),
        simulated: of(&simulated),
    });
    numbers.filter(|f| f.declared != 0.0).collect()
}
