//! The composition: actuators, a shear frame of specimens, sensors and converters.

use serde::{Deserialize, Serialize};

use crate::actuator::{Actuator, ActuatorSpec, Load};
use crate::effect::{Effect, EffectSpec, additions};
use crate::error::{Accept, RigError};
use crate::kinematics::Kinematics;
use crate::measurement::{Channels, SensorsSpec};
use crate::specimen::{SpecimenSpec, Storey};

/// The `[plant]` table of a test file. The default is an ideal actuator, a linear specimen and perfect sensors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RigSpec {
    /// Command to displacement.
    pub actuator: ActuatorSpec,
    /// Displacement to force.
    pub specimen: SpecimenSpec,
    /// What is read of both.
    pub sensors: SensorsSpec,
    /// Whatever else is wrong with it, in the order in which it acts.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSpec>,
}

impl RigSpec {
    /// The same rig with one more effect.
    ///
    /// # Errors
    /// A parameter that is missing, unknown or out of its range, by its name.
    pub fn with_effect(
        mut self,
        effect: Effect,
        parameters: &[(&str, f64)],
    ) -> Result<Self, RigError> {
        let spec = EffectSpec::new(effect, parameters);
        spec.check(&format!("plant.effects[{}]", self.effects.len()))?;
        self.effects.push(spec);
        Ok(self)
    }

    /// The rig that a test is compared with: the same specimen, of which nothing hangs on the load cell, under ideal
    /// actuators and sensors, without any effect.
    pub fn ideal(&self) -> Self {
        Self {
            actuator: ActuatorSpec::default(),
            specimen: SpecimenSpec {
                physical_mass_kg: 0.0.into(),
                ..self.specimen.clone()
            },
            sensors: SensorsSpec::default(),
            effects: Vec::new(),
        }
    }
}

/// What one control period gives; one number an axis, from the ground up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Displacement as the converters deliver it, m.
    pub displacement_m: Vec<f64>,
    /// Force as the converters deliver it, N, positive where it resists positive displacement.
    pub force_n: Vec<f64>,
    /// Displacement of the actuator, m.
    pub true_displacement_m: Vec<f64>,
    /// Force on the load cell, N.
    pub true_force_n: Vec<f64>,
    /// Some converter is at a rail.
    pub at_rail: bool,
}

/// A rig under test.
#[derive(Clone, Debug)]
pub struct Rig {
    floors: Vec<Floor>,
    reading: Reading,
}

/// One axis: the actuator at a floor, and the storey below it.
#[derive(Clone, Debug)]
struct Floor {
    actuator: Actuator,
    storey: Storey,
    /// Drift of the storey.
    drift: Kinematics,
    /// Motion of the floor.
    motion: Kinematics,
    mass_kg: f64,
    /// By what the actuator gives way to a force, m/N.
    droop_m_per_n: f64,
    /// By what the floor falls short of the actuator under a force, m/N.
    compliance_m_per_n: f64,
    channels: Channels,
    /// What the specimen puts on the actuator, inertia aside: a physical mass moves with the piston.
    load: Load,
    shear_n: f64,
    /// Displacement of the actuator, where its transducer is.
    actuator_m: f64,
}

impl Floor {
    /// Where the floor comes to stand when the actuator's dynamics would put it at `wanted_m`: both the actuator and the
    /// rig between it and the specimen give way to the force. That force is the last one, carried on with the
    /// specimen's initial stiffness; for a linear specimen this is the exact equilibrium.
    #[inline]
    fn give_way(&mut self, wanted_m: f64) -> f64 {
        let gives = self.droop_m_per_n + self.compliance_m_per_n;
        if gives == 0.0 {
            self.actuator_m = wanted_m;
            return wanted_m;
        }
        let Load {
            force_n,
            stiffness_n_per_m,
        } = self.load;
        let from = self.motion.displacement_m();
        // x = wanted - gives (F + k (x - from))
        let x = (wanted_m - gives * (force_n - stiffness_n_per_m * from))
            / (1.0 + gives * stiffness_n_per_m);
        self.actuator_m = x + self.compliance_m_per_n * (force_n + stiffness_n_per_m * (x - from));
        x
    }
}

const RATE: Accept = Accept::new(1.0, 1e6, "Hz");
const STOREY_STIFFNESS: Accept = Accept::new(1e-9, 1e12, "N/m");

impl Rig {
    /// A rig at rest at zero with one actuator for each storey of `storey_stiffness_n_per_m` (the structure's, from
    /// the ground up), of which a step takes `1 / rate_hz` s of lab time. The same seed repeats a test to the last bit.
    ///
    /// # Errors
    /// The first value of the specification that is out of its range, by its path.
    pub fn new(
        spec: &RigSpec,
        storey_stiffness_n_per_m: &[f64],
        rate_hz: f64,
        seed: u64,
    ) -> Result<Self, RigError> {
        RATE.check("the control rate", rate_hz)?;
        if storey_stiffness_n_per_m.is_empty() {
            return Err(RigError::new("the number of storeys", 0, "at least 1"));
        }
        for stiffness in storey_stiffness_n_per_m {
            STOREY_STIFFNESS.check("the stiffness of a storey", *stiffness)?;
        }
        let axes = storey_stiffness_n_per_m.len();
        let stiffness = spec.specimen.stiffness(storey_stiffness_n_per_m)?;
        let additions = additions(&spec.effects, &stiffness, rate_hz)?;
        let mut mass = spec.specimen.mass(axes)?;
        for (mass, added) in mass.iter_mut().zip(&additions) {
            *mass += added.mass_kg;
        }
        let storeys = spec.specimen.build(&stiffness, &additions)?;
        // A floor is held by the storeys below and above it.
        let held: Vec<f64> = (0..axes)
            .map(|j| stiffness[j] + stiffness.get(j + 1).unwrap_or(&0.0))
            .collect();
        let actuators = spec
            .actuator
            .build(&held, &mass, &additions, rate_hz, seed)?;
        let channels = spec
            .sensors
            .build(storey_stiffness_n_per_m, &additions, rate_hz, seed)?;
        let floors = actuators
            .into_iter()
            .zip(storeys)
            .zip(channels)
            .enumerate()
            .map(|(j, ((actuator, storey), channels))| Floor {
                actuator,
                storey,
                drift: Kinematics::new(rate_hz),
                motion: Kinematics::new(rate_hz),
                mass_kg: mass[j],
                droop_m_per_n: additions[j].droop_m_per_n,
                compliance_m_per_n: additions[j].compliance_m_per_n,
                channels,
                load: Load {
                    force_n: 0.0,
                    stiffness_n_per_m: held[j],
                },
                shear_n: 0.0,
                actuator_m: 0.0,
            })
            .collect();
        let zeros = vec![0.0; axes];
        Ok(Self {
            floors,
            reading: Reading {
                displacement_m: zeros.clone(),
                force_n: zeros.clone(),
                true_displacement_m: zeros.clone(),
                true_force_n: zeros,
                at_rail: false,
            },
        })
    }

    /// Number of actuators.
    pub fn axes(&self) -> usize {
        self.floors.len()
    }

    /// One control period: the actuators are given `command_m` (m, one an axis), and the sensors are sampled at its end.
    ///
    /// # Panics
    /// If there is not one command for each axis.
    pub fn step(&mut self, command_m: &[f64]) -> &Reading {
        assert_eq!(
            command_m.len(),
            self.floors.len(),
            "one command for each axis"
        );
        let mut below = 0.0;
        for (floor, &command) in self.floors.iter_mut().zip(command_m) {
            let actuator = floor.actuator.step(command, floor.load);
            let at = floor.give_way(actuator);
            floor.motion.advance(at);
            floor.drift.advance(at - below);
            floor.shear_n = floor.storey.step(&floor.drift);
            below = at;
        }
        let mut above_n = 0.0;
        self.reading.at_rail = false;
        for (j, floor) in self.floors.iter_mut().enumerate().rev() {
            let restoring = floor.shear_n - above_n;
            above_n = floor.shear_n;
            floor.load.force_n = restoring;
            let force = restoring + floor.mass_kg * floor.motion.acceleration_m_s2();
            let displacement = floor.actuator_m;
            let (read_m, rail_m) = floor.channels.displacement.read(displacement);
            let (read_n, rail_n) = floor.channels.force.read(force);
            self.reading.displacement_m[j] = read_m;
            self.reading.force_n[j] = read_n;
            self.reading.true_displacement_m[j] = displacement;
            self.reading.true_force_n[j] = force;
            self.reading.at_rail |= rail_m | rail_n;
        }
        &self.reading
    }

    /// What the last step gave; zeros before the first.
    pub fn reading(&self) -> &Reading {
        &self.reading
    }
}
