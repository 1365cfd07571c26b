//! A test file with a table `[coupled]`.

use super::table::CoupledTable;
use crate::files::plain::typed;
use crate::files::test::{Excitation, part};
use crate::files::units;
use outerloop_core::config::Timing;
use plant::coupled::{CoupledRig, CoupledRigSpec};
use plant::measurement::SensorsSpec;
use serde::{Deserialize, Serialize};
use std::path::Path;
use toml::{Table, Value};

/// A whole test file of two coupled actuators.
#[derive(Clone, Debug)]
pub struct CoupledTest {
    /// What is declared.
    pub coupled: CoupledTable,
    /// The rig that stands in for the laboratory.
    pub rig: CoupledRigSpec,
    /// What is read of it.
    pub sensors: SensorsSpec,
    /// Control rate, approach and hold.
    pub timing: Timing,
    /// What shakes the structure.
    pub excitation: Excitation,
    /// The file as it was used, overrides and all.
    pub text: String,
}

/// The table `[plant]` of such a file.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlantTable {
    #[serde(default)]
    sensors: SensorsSpec,
    coupled: CoupledRigSpec,
}

impl CoupledTest {
    /// The test of a table; records that it names are relative to `folder`.
    ///
    /// # Errors
    /// A key or value that cannot be used.
    pub(super) fn from_table(mut table: Table, folder: &Path) -> Result<Self, String> {
        let text = toml::to_string(&table).unwrap_or_default();
        units::convert(&mut table)?;
        let declared = table
            .remove("coupled")
            .unwrap_or(Value::Table(Table::new()));
        let plant = as_declared(table.remove("plant"), &declared);
        let coupled: CoupledTable = typed("coupled", declared)?;
        let timing: Timing = part("loop", table.remove("loop"))?;
        let mut excitation: Excitation = part("excitation", table.remove("excitation"))?;
        excitation.check()?;
        excitation.record = excitation.record.map(|record| folder.join(record));
        let plant: PlantTable = typed("plant", plant)?;
        if let Some(other) = table.keys().next() {
            return Err(format!(
                "{other} is refused: accepted beside [coupled] are [plant], [loop] and [excitation]"
            ));
        }
        if timing.time_scale != 1.0 || timing.substeps != 1 {
            return Err(format!(
                "loop.time_scale = {} and loop.substeps = {} are refused: accepted is 1 for both, since coupled actuators are \
                 tested in real time",
                timing.time_scale, timing.substeps
            ));
        }
        let test = Self {
            coupled,
            rig: plant.coupled,
            sensors: plant.sensors,
            timing,
            excitation,
            text,
        };
        CoupledRig::new(
            &test.rig,
            &test.coupled.coupler,
            &test.sensors,
            test.timing.rate_hz,
            0,
        )
        .map_err(|e| e.to_string())?;
        Ok(test)
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        self.coupled.structure.coordinates.len()
    }

    /// A sampling period, s.
    pub fn period_s(&self) -> f64 {
        1.0 / self.timing.rate_hz
    }
}

/// `[plant]` with what it leaves out of the actuators and the specimen as `declared` has it.
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
