//! What is known of a rig that is not ideal, for example from a diagnosis of its records.

use crate::refusal::{Refusal, accept, between};
use crate::rig::{self, MAX_SKEW_STEPS};
use heapless::Vec;

/// The largest number of actuators of whose channels something is known.
const MAX_ACTUATORS: usize = 4;

/// One value for each actuator, from the ground up.
pub type PerActuator = Vec<f64, MAX_ACTUATORS>;

/// How the rig departs from an ideal one, actuator by actuator from the ground up; a list that is left out: it does not.
///
/// Core takes all of it out of every sample before anything else sees it, and out of the command after everything else
/// has. The record keeps the samples as they came.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct RigConfig {
    /// True displacement per command.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub command_gain: PerActuator,
    /// True displacement at command 0, m. What is sent for a target is `(target - command_offset_m) / command_gain`.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub command_offset_m: PerActuator,
    /// Measured displacement per true displacement.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub displacement_gain: PerActuator,
    /// Measured displacement where the true one is 0, m.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub displacement_offset_m: PerActuator,
    /// Measured force per true force.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub force_gain: PerActuator,
    /// Measured force where the true one is 0, N.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub force_offset_n: PerActuator,
    /// By how much the force channel is behind the displacement channel, ms of laboratory time; negative: ahead. The
    /// channel that is ahead is held back, so that both are of the same instant.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub force_late_ms: PerActuator,
    /// Friction of the bearings that the load cell feels and the structure does not have, N.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub bearing_friction_n: PerActuator,
    /// Displacement in which this friction builds up, m.
    #[cfg_attr(feature = "schema", schemars(with = "crate::config::OneOrEach"))]
    pub bearing_presliding_m: PerActuator,
}

impl RigConfig {
    /// Checks every parameter, for so many actuators.
    pub(crate) fn check(&self, actuators: usize, rate_hz: f64) -> Result<(), Refusal> {
        let each = |name, list: &PerActuator, good: &dyn Fn(f64) -> bool, accepted| {
            let count = list.is_empty() || list.len() == actuators;
            accept(
                name,
                list.len() as f64,
                count,
                "as many values as storeys in the laboratory",
            )?;
            list.iter()
                .try_for_each(|&x| accept(name, x, good(x), accepted))
        };
        let gain = |x: f64| (0.1..=10.0).contains(&x);
        each("rig.command_gain", &self.command_gain, &gain, "0.1 to 10")?;
        each(
            "rig.displacement_gain",
            &self.displacement_gain,
            &gain,
            "0.1 to 10",
        )?;
        each("rig.force_gain", &self.force_gain, &gain, "0.1 to 10")?;
        let offset = |most: f64| move |x: f64| x.abs() <= most;
        each(
            "rig.command_offset_m",
            &self.command_offset_m,
            &offset(1.0),
            "-1 to 1 m",
        )?;
        each(
            "rig.displacement_offset_m",
            &self.displacement_offset_m,
            &offset(1.0),
            "-1 to 1 m",
        )?;
        each(
            "rig.force_offset_n",
            &self.force_offset_n,
            &offset(1e9),
            "-1e9 to 1e9 N",
        )?;
        let longest_ms = (MAX_SKEW_STEPS - 2) as f64 / rate_hz * 1e3;
        each(
            "rig.force_late_ms",
            &self.force_late_ms,
            &offset(longest_ms),
            "at most 10 control steps, late or early",
        )?;
        let friction = |x: f64| (0.0..=1e9).contains(&x);
        each(
            "rig.bearing_friction_n",
            &self.bearing_friction_n,
            &friction,
            "0 to 1e9 N",
        )?;
        for &x in &self.bearing_presliding_m {
            between(
                "rig.bearing_presliding_m",
                x,
                0.0,
                1.0,
                "above 0 and below 1 m",
            )?;
        }
        accept(
            "rig.bearing_presliding_m",
            self.bearing_presliding_m.len() as f64,
            self.bearing_presliding_m.len() == self.bearing_friction_n.len(),
            "as many values as rig.bearing_friction_n",
        )
    }

    /// The displacement that the loop takes an actuator, from 0, to have where `read_m` is read, m.
    pub fn displacement_m(&self, actuator: usize, read_m: f64) -> f64 {
        let offset_m = at(&self.displacement_offset_m, actuator, 0.0);
        (read_m - offset_m) / at(&self.displacement_gain, actuator, 1.0)
    }

    /// The force that the loop takes of an actuator, from 0, where `read_n` is read, N; what the bearings' friction is of it stays in it.
    pub fn force_n(&self, actuator: usize, read_n: f64) -> f64 {
        let offset_n = at(&self.force_offset_n, actuator, 0.0);
        (read_n - offset_n) / at(&self.force_gain, actuator, 1.0)
    }

    /// True if a command has to be corrected for the actuator's gain or offset.
    pub(crate) fn moves_commands(&self) -> bool {
        !(self.command_gain.is_empty() && self.command_offset_m.is_empty())
    }

    /// From command to true displacement.
    pub(crate) fn command<const N: usize>(&self) -> [rig::CommandMap; N] {
        core::array::from_fn(|j| {
            rig::CommandMap::new(
                at(&self.command_gain, j, 1.0),
                at(&self.command_offset_m, j, 0.0),
            )
        })
    }

    /// The constants of the step; `None` where samples need no correction. The displacement has a noise of `noise_m`
    /// rms.
    pub(crate) fn constants<const N: usize>(
        &self,
        rate_hz: f64,
        noise_m: f64,
    ) -> Option<rig::RigConstants<N>> {
        let command_only = Self {
            command_gain: self.command_gain.clone(),
            command_offset_m: self.command_offset_m.clone(),
            ..Self::default()
        };
        if *self == command_only {
            return None;
        }
        Some(core::array::from_fn(|j| {
            let known = rig::Known {
                displacement_gain: at(&self.displacement_gain, j, 1.0),
                displacement_offset_m: at(&self.displacement_offset_m, j, 0.0),
                force_gain: at(&self.force_gain, j, 1.0),
                force_offset_n: at(&self.force_offset_n, j, 0.0),
                force_late_steps: at(&self.force_late_ms, j, 0.0) * 1e-3 * rate_hz,
                friction_n: at(&self.bearing_friction_n, j, 0.0),
                presliding_m: at(&self.bearing_presliding_m, j, 1.0),
                displacement_noise_m: noise_m,
            };
            rig::AxisCorrection::new(&known)
        }))
    }
}

fn at(list: &PerActuator, j: usize, otherwise: f64) -> f64 {
    list.get(j).copied().unwrap_or(otherwise)
}
