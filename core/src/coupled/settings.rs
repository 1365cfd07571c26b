//! Turns the settings of a test with two coupled actuators into the constants of its loop.

use super::coupler::LARGEST_ROTATION;
use super::rig::{CoupledConstants, CoupledRig};
use super::tracker::{TrackerConstants, TrackerSettings};
use crate::config::Config;
use crate::design::Design;
use crate::refusal::{Refusal, accept};
use crate::structure::Structure;
use crate::supervise::InterlockLimits;

/// What a coordinate of the interface may do. Units: m and N; of a rotation rad and N m.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Bounds {
    /// Largest position that may be asked for.
    pub position: f64,
    /// Largest speed of the target, per second.
    pub speed_per_s: f64,
    /// Largest force.
    pub force: f64,
    /// Largest difference between where it was sent and where it is.
    pub tracking: f64,
}

/// What a test of two coupled actuators has beside its [`Config`], as a board is sent it.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(bound(
        serialize = "Structure<N>: serde::Serialize",
        deserialize = "Structure<N>: serde::Deserialize<'de>"
    ))
)]
pub struct CoupledSettings<const N: usize> {
    /// The structure; degrees of freedom 0 and 1 are x and rotation of the interface. What stands in the laboratory is the
    /// difference of its stiffness and its numerical stiffness.
    pub structure: Structure<N>,
    /// Coupler, actuators and observers. The target is a sampling period ahead, since the integration is explicit.
    pub tracker: TrackerSettings,
    /// What x and rotation may do.
    pub interface: [Bounds; 2],
}

impl<const N: usize> Design<N, CoupledRig> {
    /// Checks `config` and `settings` and computes the constants. `config` supplies rates, estimation, and the limits
    /// of each actuator, all of which are required: stroke, speed, force, tracking and stale samples. Its structure is
    /// only checked.
    ///
    /// # Errors
    /// The first setting that cannot be used.
    pub fn coupled(config: &Config, settings: &CoupledSettings<N>) -> Result<Self, Refusal> {
        let structure = &settings.structure;
        config.check()?;
        let matrices = [
            &structure.mass,
            &structure.damping,
            &structure.stiffness,
            &structure.numerical_stiffness,
        ];
        let numbers = matrices.into_iter().flatten().flatten();
        let lists = structure
            .influence
            .iter()
            .chain(&structure.physical_mass_kg);
        for &value in numbers.chain(lists) {
            let accepted = "finite numbers in every matrix and list";
            accept("coupled.structure", value, value.is_finite(), accepted)?;
        }
        let physical = structure.physical;
        accept(
            "structure.physical",
            physical as f64,
            physical == 2 && N >= 2,
            "2: x and rotation",
        )?;
        let t = &config.timing;
        for (name, value) in [
            ("loop.time_scale", t.time_scale),
            ("loop.substeps", f64::from(t.substeps)),
        ] {
            let accepted = "1, since coupled actuators are tested in real time";
            accept(name, value, value == 1.0, accepted)?;
        }
        let l = &config.limits;
        let given = [
            l.displacement_m,
            l.velocity_m_per_s,
            l.force_n,
            l.tracking_m,
        ];
        let of_actuators = given.map(|limit| limit.unwrap_or(f64::NAN));
        let of_interface = settings
            .interface
            .iter()
            .flat_map(|b| [b.position, b.speed_per_s, b.force, b.tracking]);
        let stale = l.stale_steps.map_or(f64::NAN, f64::from);
        for value in of_actuators.into_iter().chain(of_interface).chain([stale]) {
            let fine = value > 0.0 && value.is_finite();
            accept("coupled.limits", value, fine, "numbers above 0")?;
        }
        let turn = settings.interface[1].position;
        accept(
            "coupled.limits.rotation_rad",
            turn,
            turn <= f64::from(LARGEST_ROTATION),
            "at most 0.5 rad: the coupler's geometry is worked out up to there",
        )?;
        let period_s = settings.tracker.estimate.period_s;
        let tracker = TrackerConstants::new(&TrackerSettings {
            ahead_s: period_s,
            ..settings.tracker.clone()
        })?;
        let pins_m = settings.tracker.coupler.pin_y_m;
        let constants = CoupledConstants {
            tracker,
            limits: settings.interface.map(|b| limits(&b, t.rate_hz)),
            // Moves the pins as fast as x does, on average.
            turn_per_metre: 2.0 / (pins_m[1] - pins_m[0]).abs(),
        };
        Self::on_rig(config, structure, constants, [true, true])
    }
}

/// Limits of one coordinate.
fn limits(bounds: &Bounds, rate_hz: f64) -> InterlockLimits {
    let step = (bounds.speed_per_s / rate_hz) as f32;
    InterlockLimits {
        displacement_m: bounds.position as f32,
        reading_m: f32::MAX,
        increment_m: f32::MAX,
        velocity_step_m: step,
        least_step_m: step,
        rate_hz: rate_hz as f32,
        force_n: bounds.force as f32,
        tracking_m: bounds.tracking as f32,
        energy_warning: f32::MAX,
        energy_trip: f32::MAX,
        stale_steps: u16::MAX,
        late_steps: u16::MAX,
        locked_damping_ratio: f32::MAX,
    }
}

#[cfg(test)]
mod tests;
