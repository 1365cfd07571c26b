//! The composition: actuators, a shear frame of specimens, sensors and converters.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::actuator::{Actuator, ActuatorSpec, Load};
use crate::effect::{Effect, EffectSpec, Later, additions};
use crate::error::{Accept, RigError};
use crate::frame::{Floor, Floors};
use crate::measurement::{Channels, SensorsSpec};
use crate::specimen::SpecimenSpec;

/// The `[plant]` table of a test file. The default is an ideal actuator, a linear specimen and perfect sensors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RigSpec {
    /// Command to displacement.
    pub actuator: ActuatorSpec,
    /// Displacement to force.
    pub specimen: SpecimenSpec,
    /// What is read of both.
    pub sensors: SensorsSpec,
    /// Whatever else is wrong with it, in the order in which it acts; `from_s`: from this second of the model on;
    /// `sensor = "displacement"` or `"force"`: an error of what is read; `frozen = true` beside it: that sensor stands still
    /// with its noise.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<EffectSpec>,
}

impl RigSpec {
    /// The same rig with one more effect.
    ///
    /// # Errors
    /// A parameter that is missing, unknown or out of range, by its name.
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

    /// Stiffness of every storey, N/m, of a rig whose force is only that times the drift: linear springs with ideal
    /// actuators and sensors. `None` for any other rig.
    ///
    /// # Errors
    /// A stiffness out of range, by its path.
    pub fn elastic_n_per_m(
        &self,
        storey_stiffness_n_per_m: &[f64],
    ) -> Result<Option<Vec<f64>>, RigError> {
        let springs = Self {
            specimen: SpecimenSpec {
                stiffness_n_per_m: self.specimen.stiffness_n_per_m.clone(),
                ..SpecimenSpec::default()
            },
            ..Self::default()
        };
        if *self != springs {
            return Ok(None);
        }
        let stiffness = self.specimen.stiffness(storey_stiffness_n_per_m)?;
        Ok(Some(stiffness))
    }

    /// The reference rig for a test: the same specimen without mass on the load cell, with ideal actuators and sensors,
    /// without any effect.
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

/// The result of one control period; one number per axis, from the ground up.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Displacement as the converters deliver it, m.
    pub displacement_m: Vec<f64>,
    /// Force as the converters deliver it, N, positive if it opposes positive displacement.
    pub force_n: Vec<f64>,
    /// Displacement of the actuator, m.
    pub true_displacement_m: Vec<f64>,
    /// Force on the load cell, N.
    pub true_force_n: Vec<f64>,
    /// True if some converter is at a rail.
    pub at_rail: bool,
}

/// A rig under test.
#[derive(Clone, Debug)]
pub struct Rig {
    axes: Vec<Axis>,
    frame: Floors,
    reading: Reading,
    /// Effects yet to begin, in reverse order of time.
    later: Vec<Later>,
    /// Control periods per second of the model, and those since the start of the test, once it has begun.
    clock: Option<[f64; 2]>,
    rate_hz: f64,
}

/// The actuator and sensors of one floor.
#[derive(Clone, Debug)]
struct Axis {
    actuator: Actuator,
    /// Change of its force with its displacement, N/m.
    stiffness_n_per_m: f64,
    /// Shortfall of the floor from the actuator per force, m/N.
    compliance_m_per_n: f64,
    channels: Channels,
}

const RATE: Accept = Accept::new(1.0, 1e6, "Hz");
const STOREY_STIFFNESS: Accept = Accept::new(1e-9, 1e12, "N/m");

impl Rig {
    /// A rig at rest at zero with one actuator for each storey of `storey_stiffness_n_per_m` (the structure's, from the
    /// ground up); a step takes `1 / rate_hz` s of lab time. The same seed repeats a test to the last bit.
    ///
    /// # Errors
    /// The first value of the specification out of range, by its path.
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
        let (additions, mut later) = additions(&spec.effects, &stiffness, rate_hz, seed)?;
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
            .build(&held, &mass, &additions, &later, rate_hz, seed)?;
        let channels = spec
            .sensors
            .build(storey_stiffness_n_per_m, &additions, rate_hz, seed)?;
        let frame = storeys
            .into_iter()
            .zip(&additions)
            .zip(&mass)
            .map(|((storey, added), mass)| {
                let gives = added.droop_m_per_n + added.compliance_m_per_n;
                Floor::new(storey, *mass, gives, rate_hz)
            })
            .collect();
        let axes = actuators
            .into_iter()
            .zip(channels)
            .enumerate()
            .map(|(j, (actuator, channels))| Axis {
                actuator,
                stiffness_n_per_m: held[j],
                compliance_m_per_n: additions[j].compliance_m_per_n,
                channels,
            })
            .collect();
        let zeros = vec![0.0; mass.len()];
        later.reverse();
        Ok(Self {
            axes,
            later,
            clock: None,
            rate_hz,
            frame: Floors::new(frame),
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
        self.axes.len()
    }

    /// The test begins with the next period; `rate_hz * time_scale` periods make a second of the model. Effects that
    /// begin in mid-test are timed from here. Without this call the first period with a moving command counts as the
    /// start, and a second of the model is one of the laboratory.
    pub fn begin_test(&mut self, time_scale: f64) {
        if self.clock.is_none() {
            self.clock = Some([self.rate_hz * time_scale, 0.0]);
        }
    }

    /// Counts the period, and activates the effects that begin in it.
    #[cold]
    fn begin_later_effects(&mut self, command_m: &[f64]) {
        if self.clock.is_none() && command_m.iter().any(|c| *c != 0.0) {
            self.begin_test(1.0);
        }
        let Some([per_s, periods]) = &mut self.clock else {
            return;
        };
        while let Some(next) = self.later.pop_if(|l| l.from_s * *per_s <= *periods + 1e-6) {
            let axis = &mut self.axes[next.axis];
            let mut added = next.added;
            axis.channels
                .displacement
                .begin(std::mem::take(&mut added.displacement));
            axis.channels.force.begin(std::mem::take(&mut added.force));
            axis.compliance_m_per_n += added.compliance_m_per_n;
            axis.actuator.begin(added.clone());
            self.frame.begin(next.axis, added);
        }
        *periods += 1.0;
    }

    /// One control period: the actuators receive `command_m` (m, one per axis), and the sensors are sampled at its end.
    /// An axis whose command is not finite keeps the previous one.
    ///
    /// # Panics
    /// If there is not one command for each axis.
    pub fn step(&mut self, command_m: &[f64]) -> &Reading {
        assert_eq!(
            command_m.len(),
            self.axes.len(),
            "one command for each axis"
        );
        if !self.later.is_empty() {
            self.begin_later_effects(command_m);
        }
        let loads = self.frame.floors().iter().map(Floor::restoring_n);
        for (((axis, &command), force_n), to) in self
            .axes
            .iter_mut()
            .zip(command_m)
            .zip(loads)
            .zip(&mut self.reading.true_displacement_m)
        {
            // A physical mass moves with the piston, so its inertia is not a load here.
            let load = Load {
                force_n,
                stiffness_n_per_m: axis.stiffness_n_per_m,
            };
            *to = axis.actuator.step(command, load);
        }
        self.frame
            .step(self.reading.true_displacement_m.iter().copied());
        let reading = &mut self.reading;
        reading.at_rail = false;
        for (j, (axis, floor)) in self.axes.iter_mut().zip(self.frame.floors()).enumerate() {
            let force = floor.force_n();
            // The actuator's transducer is ahead of the compliance between it and the specimen.
            let displacement = floor.displacement_m() + axis.compliance_m_per_n * force;
            let (read_m, rail_m) = axis.channels.displacement.read(displacement);
            let (read_n, rail_n) = axis.channels.force.read(force);
            reading.displacement_m[j] = read_m;
            reading.force_n[j] = read_n;
            reading.true_displacement_m[j] = displacement;
            reading.true_force_n[j] = force;
            reading.at_rail |= rail_m | rail_n;
        }
        reading
    }

    /// The result of the last step; zeros before the first.
    pub fn reading(&self) -> &Reading {
        &self.reading
    }
}
