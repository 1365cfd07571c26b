//! `check` for a test of two coupled actuators, and options that no verb accepts for one.

use super::{hand_over, no_files};
use crate::answer::of_coupled_check;
use crate::provenance::WithProvenance;
use crate::terminal::Progress;
use experiment::Experiment;
use experiment::coupled::margins::{self, CoupledMargins};
use experiment::coupled::planned::{self, CoupledCheck};
use experiment::failure::Failure;
use experiment::soundness::Judgement;
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

/// Checks whether the test may be run.
///
/// # Errors
/// Bad input.
pub(super) fn check(
    experiment: &Experiment,
    spread: &Spread,
    wanted: (Option<&Path>, bool),
) -> Result<Judgement, Failure> {
    let (mut check, ideal, run) = {
        let progress = Progress::over("rigs", spread.plants as u64);
        planned::check(experiment, spread, || progress.add(1))?
    };
    check.judgement.add_alternatives(experiment)?;
    let margins = {
        let progress = Progress::over("margins", margins::RUNS);
        margins::of(experiment, check.judgement.verdict, spread.seed, |runs| {
            progress.add(runs);
        })?
    };
    let whole = CoupledCheckAnswer {
        check: &check,
        margins: &margins,
    };
    hand_over(wanted, no_files, |page| {
        let trace = run.trace.as_ref().filter(|_| page);
        let planned = trace.map(|trace| (trace, &ideal));
        of_coupled_check(experiment, &check, &margins, planned)
            .with_figures("check.json", &WithProvenance::seeded(&whole, spread.seed))
    })?;
    Ok(check.judgement)
}

/// The answer of `check --json` for two coupled actuators.
#[derive(Serialize, JsonSchema)]
pub(crate) struct CoupledCheckAnswer<'a> {
    #[serde(flatten)]
    check: &'a CoupledCheck,
    /// By how much delay and gains may grow.
    margins: &'a CoupledMargins,
}
