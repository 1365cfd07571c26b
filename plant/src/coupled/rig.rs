//! The composition: a pair of actuators, their coupler, a specimen, sensors and converters.

use super::actuators::{ActuatorPair, ActuatorPairSpec};
use super::coupler::CouplerSpec;
use super::pair::{Pair, within};
use super::specimen::{CoupledSpecimen, CoupledSpecimenSpec};
use crate::effect::additions;
use crate::error::RigError;
use crate::measurement::{Channels, SensorsSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The rig with two coupled actuators that stands in for the laboratory. What is left out of its tables is as declared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CoupledRigSpec {
    /// True if the actuators are where they were sent at the end of each period; what `actuators` says then does nothing.
    #[serde(default)]
    pub ideal: bool,
    /// Commands to strokes.
    pub actuators: ActuatorPairSpec,
    /// x and rotation to force and moment.
    pub specimen: CoupledSpecimenSpec,
}

/// The result of one control period, a value per actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoupledReading {
    /// Strokes as the converters deliver them, m.
    pub stroke_m: Pair,
    /// Forces as the converters deliver them, N.
    pub force_n: Pair,
    /// True strokes, m.
    pub true_stroke_m: Pair,
    /// True position of the interface, m and rad.
    pub true_interface: Pair,
    /// The specimen's response, N and N m.
    pub true_resultant: Pair,
    /// True if some converter is at a rail.
    pub at_rail: bool,
}

/// A rig with two coupled actuators under test.
#[derive(Clone, Debug)]
pub struct CoupledRig {
    ideal: bool,
    actuators: ActuatorPair,
    coupler: CouplerSpec,
    specimen: CoupledSpecimen,
    channels: Vec<Channels>,
    sent_m: Pair,
}

impl CoupledRig {
    /// At rest at zero; a step takes `1 / rate_hz` s. The same seed repeats a test to the last bit.
    ///
    /// # Errors
    /// The first value out of range, by its path.
    pub fn new(
        spec: &CoupledRigSpec,
        coupler: &CouplerSpec,
        sensors: &SensorsSpec,
        rate_hz: f64,
        seed: u64,
    ) -> Result<Self, RigError> {
        within("the control rate".into(), rate_hz, 1.0..=1e6, "1 to 1e6 Hz")?;
        coupler.check("coupled.coupler")?;
        spec.actuators.check("plant.coupled.actuators")?;
        spec.specimen.check("plant.coupled.specimen")?;
        // Without a given force range, a converter's range follows from the stiffness in x.
        let stiffness = [spec.specimen.stiffness[0][0].abs().max(1e-9); 2];
        let (none, _) = additions(&[], &stiffness, rate_hz, seed)?;
        Ok(Self {
            ideal: spec.ideal,
            actuators: ActuatorPair::new(&spec.actuators, 1.0 / rate_hz),
            coupler: coupler.clone(),
            specimen: CoupledSpecimen::new(&spec.specimen, rate_hz),
            channels: sensors.build(&stiffness, &none, rate_hz, seed)?,
            sent_m: [0.0; 2],
        })
    }

    /// One control period under held commands, m, sampled at its end. A non-finite command keeps the previous one.
    pub fn step(&mut self, command_m: Pair) -> CoupledReading {
        for (sent, command) in self.sent_m.iter_mut().zip(command_m) {
            if command.is_finite() {
                *sent = command;
            }
        }
        let strokes = if self.ideal {
            self.sent_m
        } else {
            self.actuators.step(self.sent_m);
            self.actuators.strokes_m()
        };
        let interface = self.coupler.interface(strokes);
        let resultant = self.specimen.step(interface);
        let force_n = self.coupler.forces_n(resultant, interface[1]);
        let mut reading = CoupledReading {
            true_stroke_m: strokes,
            true_interface: interface,
            true_resultant: resultant,
            ..CoupledReading::default()
        };
        for (i, channels) in self.channels.iter_mut().enumerate().take(2) {
            let (stroke, rail_m) = channels.displacement.read(strokes[i]);
            let (force, rail_n) = channels.force.read(force_n[i]);
            (reading.stroke_m[i], reading.force_n[i]) = (stroke, force);
            reading.at_rail |= rail_m | rail_n;
        }
        reading
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rig(ideal: bool) -> CoupledRig {
        let spec = CoupledRigSpec {
            ideal,
            actuators: ActuatorPairSpec {
                gain: [[0.9, 0.1], [0.15, 0.95]],
                slow_pole_hz: [3.0, 4.0],
                fast_pole_hz: [40.0, 20.0],
                lead_ms: [[0.0; 2]; 2],
                path_lead_ms: [[0.0; 2]; 2],
                natural_hz: 80.0,
                damping_ratio: 0.6,
                delay_ms: [0.0; 2],
            },
            specimen: CoupledSpecimenSpec {
                stiffness: [[1e5, 3e4], [3e4, 9e4]],
                damping: [[0.0; 2]; 2],
                mass: [[0.0; 2]; 2],
                springs: Vec::new(),
            },
        };
        let coupler = CouplerSpec {
            pin_x_m: [0.2667; 2],
            pin_y_m: [-0.127, 0.127],
        };
        CoupledRig::new(&spec, &coupler, &SensorsSpec::default(), 1024.0, 1).unwrap()
    }

    #[test]
    fn the_actuators_do_the_work_that_the_specimen_stores() {
        let mut rig = rig(false);
        let (mut work, mut last) = (0.0, CoupledReading::default());
        for k in 0..2000 {
            let t = f64::from(k) / 1024.0;
            let now = rig.step([0.02 * (9.0 * t).sin(), 0.03 * (14.0 * t).sin()]);
            for i in 0..2 {
                work += 0.5
                    * (now.force_n[i] + last.force_n[i])
                    * (now.true_stroke_m[i] - last.true_stroke_m[i]);
            }
            last = now;
        }
        let [x, theta] = last.true_interface;
        assert!(theta.abs() > 1e-3);
        let stored = 0.5 * (1e5 * x * x + 9e4 * theta * theta) + 3e4 * x * theta;
        assert!((work - stored).abs() < 1e-4 * stored, "{work} {stored}");
    }

    #[test]
    fn ideal_actuators_are_where_they_are_sent_and_a_nan_moves_nothing() {
        let mut rig = rig(true);
        assert_eq!(rig.step([1e-3, -2e-3]).true_stroke_m, [1e-3, -2e-3]);
        assert_eq!(rig.step([f64::NAN, 0.0]).true_stroke_m, [1e-3, 0.0]);
    }
}
