//! A test file with a table `[coupled]`, and its test on a ground motion.

use super::settings;
use super::table::CoupledTable;
use crate::experiment::{self, Shaken};
use crate::failure::Failure;
use crate::files::ground_motion::GroundMotionFile;
use crate::files::test::{Excitation, parse, part, typed};
use crate::files::units;
use outerloop_core::GroundMotion;
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
    /// Reads `path` with the overrides `PATH=VALUE`; `None` where it is a test of another kind, or cannot be read at all.
    ///
    /// # Errors
    /// A key or value that cannot be used.
    pub fn of(path: &Path, overrides: &[String]) -> Result<Option<Self>, Failure> {
        let Ok(text) = std::fs::read_to_string(path) else {
            return Ok(None);
        };
        if !text
            .parse::<Table>()
            .is_ok_and(|t| t.contains_key("coupled"))
        {
            return Ok(None);
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::parse(&text, &path.display().to_string(), folder, overrides).map(Some)
    }

    /// Reads `text`, which came from `file`; records that it names are relative to `folder`.
    ///
    /// # Errors
    /// A key or value that cannot be used.
    pub fn parse(
        text: &str,
        file: &str,
        folder: &Path,
        overrides: &[String],
    ) -> Result<Self, Failure> {
        parse(text, file, overrides, |table| {
            Self::from_table(table, folder)
        })
    }

    fn from_table(mut table: Table, folder: &Path) -> Result<Self, String> {
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
        settings::check(&test)?;
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

/// A test and what shakes it.
#[derive(Clone, Debug)]
pub struct CoupledExperiment {
    /// What is tested.
    pub test: CoupledTest,
    /// Name of the ground motion.
    pub record: String,
    /// What is laid under the test.
    pub shaken: Shaken,
    /// Factor on the ground motion.
    pub scale: f64,
}

impl CoupledExperiment {
    /// Lays `test` over `shaking`.
    ///
    /// # Errors
    /// A duration that is refused; a ground motion that cannot be laid out, or that moves nothing where its factor is sought.
    pub fn new(
        test: CoupledTest,
        shaking: &GroundMotionFile,
        duration_s: Option<f64>,
    ) -> Result<Self, Failure> {
        let mut experiment = Self {
            shaken: experiment::shaken(&test.excitation, shaking, duration_s)?,
            record: shaking.name.clone(),
            scale: test.excitation.scale,
            test,
        };
        if let Some(peak_mm) = experiment.test.excitation.peak_response_mm {
            let mut linear = experiment.clone();
            linear.test.rig.specimen.springs.clear();
            let peak_m = super::trial::ideal(&linear)?.peak(0);
            experiment.scale = 1e-3 * peak_mm / peak_m;
        }
        let factor = experiment.scale as f32;
        for point in &mut experiment.shaken.acc_m_per_s2 {
            *point *= factor;
        }
        Ok(experiment)
    }

    /// Control steps of the running test.
    pub fn steps(&self) -> usize {
        (self.shaken.seconds * self.test.timing.rate_hz).round() as usize
    }

    /// What shakes the structure, step by step.
    ///
    /// # Errors
    /// An interval that cannot be laid over the steps.
    pub fn ground(&self) -> Result<GroundMotion<'_>, Failure> {
        let period_s = self.test.period_s();
        let interval_s = self.shaken.interval_s;
        GroundMotion::new(&self.shaken.acc_m_per_s2, interval_s, period_s).ok_or_else(|| {
            Failure::input(format!(
                "{}: an interval of {interval_s} s cannot be laid over steps of {period_s} s",
                self.record
            ))
        })
    }
}
