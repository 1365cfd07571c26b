//! `check` for a test of two coupled actuators, and options that no verb accepts for one.

use super::{hand_over, json, no_files};
use crate::answer::of_coupled_check;
use crate::provenance::WithProvenance;
use crate::terminal::Progress;
use experiment::Experiment;
use experiment::coupled::margins::{self, CoupledMargins};
use experiment::coupled::planned::{self, CoupledCheck};
use experiment::failure::Failure;
use experiment::files::ground_motion::GroundMotionFile;
use experiment::files::test::TestFile;
use experiment::stability::perturbed::Spread;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;

/// Refuses options that do not apply to such a test.
///
/// # Errors
/// The first of them that was given.
pub(super) fn refuse(asked: &[(&str, bool)]) -> Result<(), Failure> {
    match asked.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(Failure::input(format!(
            "{option} has no meaning for a test of two coupled actuators, [coupled]: accepted are run, compare, \
             check, sweep, serve, replay and diff, and of these run and serve on a board, too"
        ))),
    }
}

/// The request for a check.
pub(super) struct CoupledCheckRequest<'a> {
    /// The ground motion.
    pub shaking: GroundMotionFile,
    /// The compensation, instead of that of the file.
    pub compensation: Option<&'a str>,
    /// The spread of the rigs.
    pub spread: Spread,
    /// Where results are written.
    pub out: Option<&'a Path>,
    /// Only JSON on standard output.
    pub json: bool,
}

/// Checks whether the test may be run.
///
/// # Errors
/// Bad input; a test that may not be run.
pub(super) fn check(test: &TestFile, asked: &CoupledCheckRequest<'_>) -> Result<(), Failure> {
    let mut experiment = Experiment::new(test.clone(), &asked.shaking, None)?;
    if let Some(name) = asked.compensation {
        experiment = experiment.under(test.compensation_named(name)?)?;
    }
    let seed = asked.spread.seed;
    let (mut check, ideal, run) = {
        let progress = Progress::over("rigs", asked.spread.plants as u64);
        planned::check(&experiment, &asked.spread, || progress.add(1))?
    };
    check.judgement.add_alternatives(&experiment)?;
    let margins = {
        let progress = Progress::over("margins", margins::RUNS);
        margins::of(&experiment, check.judgement.verdict, seed, |runs| {
            progress.add(runs);
        })?
    };
    let whole = CoupledCheckAnswer {
        check: &check,
        margins: &margins,
    };
    let text = json(&WithProvenance::seeded(&whole, seed))?;
    hand_over(
        (asked.out, asked.json),
        ("check.json", &text),
        no_files,
        |page| {
            let planned = run
                .trace
                .as_ref()
                .filter(|_| page)
                .map(|trace| (trace, &ideal));
            Ok(of_coupled_check(&experiment, &check, &margins, planned))
        },
    )?;
    let (verdict, reason) = (check.judgement.verdict, &check.judgement.reason);
    verdict.outcome(format!("{}: {reason}", verdict.name()))
}

/// The answer of `check --json` for two coupled actuators.
#[derive(Serialize, JsonSchema)]
pub(crate) struct CoupledCheckAnswer<'a> {
    #[serde(flatten)]
    check: &'a CoupledCheck,
    /// By how much delay and gains may grow.
    margins: &'a CoupledMargins,
}
