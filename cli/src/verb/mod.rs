//! One file a verb.

pub mod compare;
pub mod demo;
pub mod effects;

pub mod run;

use crate::failure::Failure;
use crate::files::ground_motion::{Columns, GroundMotionFile, Unit};
use crate::files::near_fault::near_fault;
use crate::files::test::TestFile;
use outerloop_core::Method;
use std::path::{Path, PathBuf};

/// What `run` and `compare` have in common.
#[derive(clap::Args, Debug)]
pub struct Common {
    /// The test file
    pub test: PathBuf,
    /// Interval of a ground motion that has one acceleration a line, s
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub dt: Option<f64>,
    /// Unit of such a ground motion
    #[arg(long, value_name = "UNIT")]
    pub unit: Option<Unit>,
    /// Override a value of the test file, e.g. plant.actuator.delay_ms=8
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub overrides: Vec<String>,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Seconds of model time; left out: the whole record
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub duration: Option<f64>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    pub json: bool,
}

impl Common {
    fn load(&self) -> Result<TestFile, Failure> {
        TestFile::load(&self.test, &self.overrides)
    }

    /// The ground motion: named here, else by the test, else the built-in one.
    fn shaking(&self, test: &TestFile, named: Option<&Path>) -> Result<GroundMotionFile, Failure> {
        let columns = Columns {
            interval_s: self.dt,
            unit: self.unit,
        };
        match named.or(test.excitation.record.as_deref()) {
            Some(path) => GroundMotionFile::load(path, columns),
            None => Ok(near_fault()),
        }
    }

    /// How long to run: named here, else by the test, else the whole record.
    fn seconds(&self, test: &TestFile, shaking: &GroundMotionFile) -> Result<f64, Failure> {
        seconds(self.duration.or(test.excitation.duration_s), shaking)
    }
}

/// The duration of a test on `shaking`.
///
/// # Errors
/// A duration that is no positive number.
pub fn seconds(wanted: Option<f64>, shaking: &GroundMotionFile) -> Result<f64, Failure> {
    let whole = (shaking.acc_m_per_s2.len() - 1) as f64 * shaking.interval_s;
    match wanted {
        None => Ok(whole),
        Some(s) if s > 0.0 && s.is_finite() => Ok(s.min(whole)),
        Some(s) => Err(Failure::input(format!(
            "a duration of {s} s is refused: accepted are seconds above 0"
        ))),
    }
}

/// A compensation by its name.
///
/// # Errors
/// A name that no compensation has.
pub fn method(name: &str) -> Result<Method, Failure> {
    Method::ALL
        .into_iter()
        .find(|m| m.name() == name)
        .ok_or_else(|| {
            let names: Vec<_> = Method::ALL.into_iter().map(Method::name).collect();
            Failure::input(format!(
                "compensation `{name}` is unknown: accepted are {}",
                names.join(", ")
            ))
        })
}
