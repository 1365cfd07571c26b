//! The contents specific to a test file of two coupled actuators.

use super::settings;
use super::table::CoupledTable;
use crate::files::plain::{part, typed};
use outerloop_core::{Config, Method, config::Limits, config::Timing};
use plant::coupled::{CoupledRig, CoupledRigSpec};
use plant::measurement::SensorsSpec;
use plant::{RigError, RigSpec};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

/// What is declared of two coupled actuators, and the rig that stands in for them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct CoupledPart {
    /// What is declared.
    pub declared: CoupledTable,
    /// The rig that stands in for the laboratory; its sensors are those of [`RigSpec`].
    pub rig: CoupledRigSpec,
}

/// The table `[plant]` of such a file.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct PlantTable {
    #[serde(default)]
    sensors: SensorsSpec,
    coupled: CoupledRigSpec,
}

impl CoupledPart {
    /// Takes `[coupled]`, `[plant]` and `[loop]` from a table that has no other keys: the part, the sensors of the
    /// simulated rig, and core's configuration.
    ///
    /// # Errors
    /// A key or value that cannot be used.
    pub(crate) fn take(mut table: Table) -> Result<(Self, RigSpec, Config), String> {
        let declared = table
            .remove("coupled")
            .unwrap_or(Value::Table(Table::new()));
        let plant = as_declared(table.remove("plant"), &declared);
        let declared: CoupledTable = typed("coupled", declared)?;
        let timing: Timing = part("loop", table.remove("loop"))?;
        let plant: PlantTable = typed("plant", plant)?;
        if let Some(other) = table.keys().next() {
            return Err(format!(
                "{other} is refused: accepted beside [coupled] are [plant], [loop], [serve] and [excitation]"
            ));
        }
        let own = Self {
            declared,
            rig: plant.coupled,
        };
        let config = own.config(timing);
        own.simulated(&plant.sensors, config.timing.rate_hz, 0)
            .map_err(|e| e.to_string())?;
        settings::check(&own.declared, &config)?;
        let sensors = RigSpec {
            sensors: plant.sensors,
            ..RigSpec::default()
        };
        Ok((own, sensors, config))
    }

    /// The rig that stands in for the laboratory; `seed`: of everything random in it.
    ///
    /// # Errors
    /// A parameter that is refused.
    pub fn simulated(
        &self,
        sensors: &SensorsSpec,
        rate_hz: f64,
        seed: u64,
    ) -> Result<CoupledRig, RigError> {
        CoupledRig::new(&self.rig, &self.declared.coupler, sensors, rate_hz, seed)
    }

    /// Core's configuration besides the part: rates, and the limits of each actuator. Of the structure it has what
    /// lists can express.
    fn config(&self, timing: Timing) -> Config {
        let (s, l) = (&self.declared.structure, &self.declared.limits);
        let diagonal = |m: &[Vec<f64>]| {
            let own = m.iter().enumerate();
            own.filter_map(|(j, row)| row.get(j).copied())
                .take(s.coordinates.len().min(outerloop_core::config::MAX_DOF))
                .collect()
        };
        let mut config = Config::shear_frame([1.0; 2], [1.0; 2], [0.0; 2]);
        config.structure.mass_kg = diagonal(&s.mass);
        config.structure.stiffness_n_per_m = diagonal(&s.stiffness);
        config.structure.damping_ratio = (0..config.degrees_of_freedom())
            .map(|j| s.damping_ratio.at(j))
            .collect();
        config.structure.physical_storeys = Some(2);
        config.timing = timing;
        config.compensation.kind = Method::None;
        config.limits = Limits {
            displacement_m: Some(l.stroke_m),
            velocity_m_per_s: Some(l.velocity_m_per_s),
            force_n: Some(l.force_n),
            tracking_m: Some(l.tracking_m),
            stale_steps: Some(l.stale_steps),
            frozen_m: Some(l.frozen_m),
            force_stands_m: l.force_stands_m,
            disagree_m: l.disagree_m,
            ..Limits::default()
        };
        config
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.declared.structure.coordinates.len()
    }
}
/// `[plant]`, with actuators and specimen from `declared` where it omits them.
fn as_declared(plant: Option<Value>, declared: &Value) -> Value {
    let mut plant = match plant {
        Some(Value::Table(plant)) => plant,
        Some(other) => return other,
        None => Table::new(),
    };
    let own = plant
        .entry("coupled")
        .or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(own) = own {
        for name in ["actuators", "specimen"] {
            let mut whole = declared.get(name).cloned().unwrap_or(Value::Boolean(false));
            match (&mut whole, own.remove(name)) {
                (Value::Table(whole), Some(Value::Table(given))) => whole.extend(given),
                (whole, Some(given)) => *whole = given,
                (_, None) => {}
            }
            own.insert(name.into(), whole);
        }
    }
    Value::Table(plant)
}
