//! The test file: what is tested, how, and on which simulated rig.

use super::read;
use crate::failure::Failure;
use outerloop_core::Config;
use outerloop_core::config::StructureConfig;
use outerloop_core::structure::Structure;
use plant::RigSpec;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use toml::{Table, Value};

/// A whole test file.
#[derive(Clone, Debug)]
pub struct TestFile {
    /// What core is configured with.
    pub config: Config,
    /// The rig that stands in for the laboratory.
    pub plant: RigSpec,
    /// What shakes the structure.
    pub excitation: Excitation,
}

/// `[excitation]`: which ground motion, how strong, how long.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Excitation {
    /// A file, relative to the test file; left out: the built-in near-fault record.
    pub record: Option<PathBuf>,
    /// Factor on the acceleration.
    pub scale: f64,
    /// Seconds of model time; left out: the whole record.
    pub duration_s: Option<f64>,
}

impl Default for Excitation {
    fn default() -> Self {
        Self {
            record: None,
            scale: 1.0,
            duration_s: None,
        }
    }
}

impl TestFile {
    /// Reads `path` and applies the overrides `PATH=VALUE`.
    ///
    /// # Errors
    /// A file, key or value that cannot be used.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, Failure> {
        let name = path.display().to_string();
        let mut table: Table = read(path)?
            .parse()
            .map_err(|e: toml::de::Error| Failure::input(format!("{name}: {}", one_line(&e))))?;
        for assignment in overrides {
            set(&mut table, assignment)?;
        }
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_table(table, &name, folder)
    }

    /// Makes a test of an already parsed table; `folder` is where relative records lie.
    ///
    /// # Errors
    /// A key or value that cannot be used.
    pub fn from_table(mut table: Table, name: &str, folder: &Path) -> Result<Self, Failure> {
        let plant = part::<RigSpec>(name, "plant", table.remove("plant"))?;
        let mut excitation = part::<Excitation>(name, "excitation", table.remove("excitation"))?;
        if !(excitation.scale.is_finite() && excitation.scale.abs() < 1e3) {
            return Err(Failure::input(format!(
                "{name}: excitation.scale = {} is refused: accepted are factors below 1000",
                excitation.scale
            )));
        }
        excitation.record = excitation.record.map(|record| folder.join(record));
        lists_of_one(&mut table);
        // The clamp of the compensation is built on the delay that is expected: on a simulated rig, the rig's.
        let delay_ms = plant_delay_ms(&plant);
        if let Value::Table(compensation) = table
            .entry("compensation")
            .or_insert_with(|| Value::Table(Table::new()))
            && delay_ms > 0.0
        {
            compensation
                .entry("delay_ms")
                .or_insert(Value::Float(delay_ms));
        }
        let config: Config = Value::Table(table)
            .try_into()
            .map_err(|e: toml::de::Error| Failure::input(format!("{name}: {}", one_line(&e))))?;
        config
            .check()
            .map_err(|e| Failure::input(format!("{name}: {e}")))?;
        Ok(Self {
            config,
            plant,
            excitation,
        })
    }
}

impl TestFile {
    /// Fundamental natural angular frequency of the declared structure, rad/s.
    pub fn fundamental_rad_per_s(&self) -> f64 {
        fn of<const N: usize>(s: &StructureConfig) -> Option<f64> {
            let floors =
                |list: &[f64]| core::array::from_fn(|j| list.get(j).copied().unwrap_or(0.0));
            let frame = Structure::<N>::shear_frame(
                &floors(&s.mass_kg),
                &floors(&s.stiffness_n_per_m),
                &floors(&s.damping_ratio),
                N,
                &[0.0; N],
            );
            Some(frame.ok()?.natural_frequencies_rad_per_s().ok()?[0])
        }
        let s = &self.config.structure;
        let omega = match s.mass_kg.len() {
            1 => of::<1>(s),
            2 => of::<2>(s),
            3 => of::<3>(s),
            4 => of::<4>(s),
            5 => of::<5>(s),
            6 => of::<6>(s),
            7 => of::<7>(s),
            _ => of::<8>(s),
        };
        omega.unwrap_or(f64::NAN)
    }
}

/// The delay of the rig's first actuator, with its lag, ms.
fn plant_delay_ms(plant: &RigSpec) -> f64 {
    let table = Value::try_from(&plant.actuator).ok();
    let number = |key: &str| {
        let value = table.as_ref()?.get(key)?;
        let first = value
            .as_array()
            .and_then(|list| list.first())
            .unwrap_or(value);
        first
            .as_float()
            .or_else(|| first.as_integer().map(|i| i as f64))
    };
    number("delay_ms").unwrap_or(0.0) + number("lag_ms").unwrap_or(0.0)
}

fn part<T: for<'a> Deserialize<'a> + Default>(
    file: &str,
    name: &str,
    value: Option<Value>,
) -> Result<T, Failure> {
    match value {
        None => Ok(T::default()),
        Some(value) => value.try_into().map_err(|e: toml::de::Error| {
            Failure::input(format!("{file}: {name}: {}", one_line(&e)))
        }),
    }
}

/// One degree of freedom is written as numbers: core takes lists.
fn lists_of_one(table: &mut Table) {
    let Some(Value::Table(structure)) = table.get_mut("structure") else {
        return;
    };
    for key in [
        "mass_kg",
        "stiffness_n_per_m",
        "damping_ratio",
        "physical_mass_kg",
    ] {
        if let Some(value) = structure.get_mut(key)
            && !value.is_array()
        {
            *value = Value::Array(vec![value.clone()]);
        }
    }
}

/// Sets one value by its dotted path. Whether the path exists is found out when the table is read.
fn set(table: &mut Table, assignment: &str) -> Result<(), Failure> {
    let (path, text) = assignment.split_once('=').ok_or_else(|| {
        Failure::input(format!(
            "--set {assignment}: accepted are PATH=VALUE, e.g. loop.rate_hz=2000"
        ))
    })?;
    let value = format!("x = {text}")
        .parse::<Table>()
        .ok()
        .and_then(|mut t| t.remove("x"))
        .unwrap_or_else(|| Value::String(text.to_owned()));
    let mut here = table;
    let mut keys: Vec<&str> = path.trim().split('.').collect();
    let last = keys.pop().unwrap_or_default();
    for key in keys {
        let next = here
            .entry(key)
            .or_insert_with(|| Value::Table(Table::new()));
        here = next.as_table_mut().ok_or_else(|| {
            Failure::input(format!(
                "--set {assignment}: `{key}` is a value and has no parts"
            ))
        })?;
    }
    here.insert(last.to_owned(), value);
    Ok(())
}

/// The message of a TOML error without its picture, on one line.
fn one_line(e: &toml::de::Error) -> String {
    e.message().replace('\n', " ")
}
