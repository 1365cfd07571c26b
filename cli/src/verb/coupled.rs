//! `check` of a test of two coupled actuators, and what no verb does with one.

use super::{hand_over, json};
use crate::provenance::WithProvenance;
use crate::report::{self, TestSection};
use crate::terminal::coupled_test::{LIMIT_HEAD, limit_row};
use crate::terminal::{Progress, table};
use experiment::Experiment;
use experiment::coupled::planned::{self, CoupledCheck};
use experiment::failure::Failure;
use experiment::files::ground_motion::GroundMotionFile;
use experiment::files::test::TestFile;
use experiment::numbers::percent;
use experiment::stability::perturbed::Spread;
use std::path::Path;

/// That nothing was asked for that such a test does not have.
///
/// # Errors
/// The first that was.
pub(super) fn refuse(asked: &[(&str, bool)]) -> Result<(), Failure> {
    match asked.iter().find(|(_, given)| *given) {
        None => Ok(()),
        Some((option, _)) => Err(Failure::input(format!(
            "{option} has no meaning for a test of two coupled actuators, [coupled]: accepted are run, compare, \
             check, sweep, replay and diff, on the simulated rig; no board has their loop yet"
        ))),
    }
}

/// What is asked of a check.
pub(super) struct CoupledCheckRequest<'a> {
    /// The ground motion.
    pub shaking: GroundMotionFile,
    /// The compensation, instead of the file's.
    pub compensation: Option<&'a str>,
    /// How rigs differ.
    pub spread: Spread,
    /// Where results go.
    pub out: Option<&'a Path>,
    /// JSON alone.
    pub json: bool,
}

/// True if the test may be run.
///
/// # Errors
/// Bad input; a test that may not be run.
pub(super) fn check(test: &TestFile, asked: &CoupledCheckRequest<'_>) -> Result<(), Failure> {
    let kind = match asked.compensation {
        Some(name) => test.compensation_named(name)?,
        None => test.compensation(),
    };
    let experiment = Experiment::new(test.clone(), &asked.shaking, None)?;
    let (check, ideal, run) = {
        let progress = Progress::over("rigs", asked.spread.plants as u64);
        planned::check(&experiment, kind, &asked.spread, || progress.add(1))?
    };
    let page = || {
        let section = run.trace.as_ref().map(|trace| TestSection {
            experiment: &experiment,
            summary: &check.planned,
            trace,
            ideal: &ideal,
        });
        let page = section.map(|section| report::of_coupled_check(&check, &section));
        Ok(page.map(|page| ("report.html", page)).into_iter().collect())
    };
    let text = json(&WithProvenance::seeded(&check, asked.spread.seed))?;
    hand_over((asked.out, asked.json), ("check.json", &text), page, || {
        print_check(&experiment, &check);
    })?;
    let said = format!("{}: {}", check.verdict.name(), check.reason);
    check.verdict.outcome(said)
}

fn print_check(experiment: &Experiment, check: &CoupledCheck) {
    println!(
        "{}: {}.\nExpected error: {} rms; at worst {} on a rig that differs.\n",
        check.verdict.name().to_uppercase(),
        check.reason.trim_end_matches('.'),
        percent(check.expected_eps_rms),
        percent(check.expected_eps_rms_differing),
    );
    println!("{}", experiment.in_words());
    let mut limits = table(&LIMIT_HEAD);
    limits.add_rows(check.limits.iter().map(limit_row));
    println!(
        "{limits}\n\n{} of {} rigs that differ are lost.",
        check.lost, check.plants,
    );
}
