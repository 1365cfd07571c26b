//! Test files of two coupled actuators, and their tests on ground motions: read, checked, laid out.

use super::experiment::CoupledExperiment;
use super::file::CoupledTest;
use super::{settings, trial};
use crate::experiment::shaken;
use crate::failure::Failure;
use crate::files::ground_motion::GroundMotionFile;
use crate::files::test;
use std::path::Path;
use toml::Table;

/// Reads `path` with the overrides `PATH=VALUE`; `None` where it is a test of another kind, or cannot be read at all.
///
/// # Errors
/// A key or value that cannot be used.
pub fn test(path: &Path, overrides: &[String]) -> Result<Option<CoupledTest>, Failure> {
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
    parse(&text, &path.display().to_string(), folder, overrides).map(Some)
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
) -> Result<CoupledTest, Failure> {
    test::parse(text, file, overrides, |table| {
        let test = CoupledTest::from_table(table, folder)?;
        settings::check(&test)?;
        Ok(test)
    })
}

/// Lays `test` over `shaking`.
///
/// # Errors
/// A duration that is refused; a ground motion that cannot be laid out, or that moves nothing where its factor is sought.
pub fn experiment(
    test: CoupledTest,
    shaking: &GroundMotionFile,
    duration_s: Option<f64>,
) -> Result<CoupledExperiment, Failure> {
    let mut experiment = CoupledExperiment {
        shaken: shaken(&test.excitation, shaking, duration_s)?,
        record: shaking.name.clone(),
        scale: test.excitation.scale,
        test,
    };
    if let Some(peak_mm) = experiment.test.excitation.peak_response_mm {
        let mut linear = experiment.clone();
        linear.test.rig.specimen.springs.clear();
        experiment.scale = 1e-3 * peak_mm / trial::ideal(&linear)?.peak(0);
    }
    let factor = experiment.scale as f32;
    for point in &mut experiment.shaken.acc_m_per_s2 {
        *point *= factor;
    }
    Ok(experiment)
}
