//! `outerloop improve`: a test, the diagnosis of its record, and the test improved by what was found.

use super::rig_arguments::RigArguments;
use super::{CommonArguments, hand_over_tests, require_all_ran};
use crate::answer::of_improvements;
use crate::designed_test;
use crate::improve::{DESIGNED, FirstTest, Improvement, ImprovementOutcome};
use crate::provenance::WithProvenance;
use crate::site::{RigKind, TestSite};
use crate::terminal::{Progress, interrupt};
use diagnosis::{Diagnosis, Model};
use experiment::failure::Failure;
use experiment::files::{look_ahead, model, output, record_csv};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Run a test, diagnose its record, play designed tests for what stays open, and run the test again with what was
/// found
#[derive(clap::Args, Debug)]
pub struct Improve {
    #[command(flatten)]
    common: CommonArguments,
    /// More tests
    #[arg(value_name = "TEST")]
    more: Vec<PathBuf>,
    /// The ground motion: CSV, AT2, or one acceleration a line
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// The declared model; left out: what the test file declares of its rig
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Write report.html and summary.json there, and of each test its record, its model (unless the second test is worse) and
    /// its designed tests
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    #[command(flatten)]
    place: RigArguments,
}

/// All rows as JSON.
#[derive(Serialize, JsonSchema)]
pub(crate) struct ImprovementRows<'a> {
    place: RigKind,
    rows: Vec<ImprovementRow<'a>>,
}

/// A row as JSON.
#[derive(Serialize, JsonSchema)]
pub(crate) struct ImprovementRow<'a> {
    test: String,
    undeclared: String,
    found: String,
    eps_rms_before: f64,
    eps_rms_after: f64,
    eps_rms_without: Option<f64>,
    outcome: ImprovementOutcome,
    eps_max_before: f64,
    eps_max_after: f64,
    remains: String,
    found_first: String,
    designed: Vec<&'a diagnosis::Next>,
    changes: &'a [String],
    diagnosis: &'a Diagnosis,
}

impl Improve {
    /// Improves the tests.
    ///
    /// # Errors
    /// Bad input; a test that cannot be diagnosed; a second test that is worse than the first.
    pub fn run(&self) -> Result<(), Failure> {
        let files: Vec<PathBuf> = self.common.files(&self.more);
        let out = look_ahead::folder(self.out.as_deref(), &written(&files))?;
        let out = out.as_deref();
        // A mistake in the last file is refused before the first test has run for minutes.
        for file in &files {
            self.common.load_other(file)?;
        }
        let mut improvements = Vec::new();
        interrupt::watch();
        for file in &files {
            match self.improve_test(file, out) {
                Ok(improvement) => improvements.push(improvement),
                // The results of earlier tests are kept.
                Err(stopped) if interrupt::asked() => {
                    eprintln!("outerloop: {}: {stopped}", file.display());
                }
                Err(failure) => return Err(failure),
            }
            if interrupt::asked() {
                break;
            }
        }
        if improvements.is_empty() {
            return require_all_ran(0, files.len());
        }
        let named: Vec<(String, &Improvement)> =
            files.iter().map(|f| stem(f)).zip(&improvements).collect();
        let rows = ImprovementRows {
            place: self.place.kind(),
            rows: named.iter().map(|(name, s)| row(name, s)).collect(),
        };
        hand_over_tests(
            (improvements.len(), files.len()),
            (out, self.common.json),
            || files_of(&named),
            |page| {
                of_improvements(&named, page).with_figures(
                    "summary.json",
                    &WithProvenance::seeded(&rows, self.common.seed),
                )
            },
        )?;
        let worse: Vec<&str> = named
            .iter()
            .filter(|(_, s)| s.outcome() == ImprovementOutcome::Worse)
            .map(|(name, _)| name.as_str())
            .collect();
        if worse.is_empty() {
            require_all_ran(improvements.len(), files.len())
        } else {
            Err(Failure::test(format!(
                "{}: the second test is worse than the first; do not use what was found (its model is not written)",
                worse.join(", ")
            )))
        }
    }

    fn improve_test(&self, file: &Path, out: Option<&Path>) -> Result<Improvement, Failure> {
        let test = self.common.load_other(file)?;
        let declared = match &self.model {
            Some(path) => model::load(path)?,
            None => test.declared_model().ok_or_else(|| {
                Failure::input(format!(
                    "{}: its rig is more than a model can say: accepted is one actuator of the kinds ideal, delay, \
                     first_order and lag_delay, or a model by --model",
                    file.display()
                ))
            })?,
        };
        let experiment = self.common.experiment(&test, self.record.as_deref())?;
        let progress = Progress::over(&experiment.record, Improvement::steps(&experiment) as u64);
        let (place, seed) = (&self.place, self.common.seed);
        let first = FirstTest::run(experiment, place, seed, &progress)?;
        let told = Improvement::of(first.clone(), &declared, place, seed, &progress);
        told.inspect_err(|_| keep_first(&first, file, out))
    }
}

/// Keeps the record of the first test if the rest fails: its specimen may not be available a second time.
fn keep_first(first: &FirstTest, file: &Path, out: Option<&Path>) {
    let (Some(trace), Some(folder)) = (first.trace(), out) else {
        return;
    };
    let name = format!("{}-record.csv", stem(file));
    match output::write_all(folder, &[(&name, record_csv::to_csv(trace))]) {
        Ok(()) => eprintln!(
            "outerloop: the record of the first test is kept: {}",
            folder.join(name).display()
        ),
        Err(failure) => eprintln!("outerloop: {failure}"),
    }
}

fn row<'a>(name: &str, s: &'a Improvement) -> ImprovementRow<'a> {
    ImprovementRow {
        test: name.to_owned(),
        undeclared: s.undeclared(),
        found: Improvement::named(&s.diagnosis),
        eps_rms_before: s.before.summary.eps_rms,
        eps_rms_after: s.after.summary.eps_rms,
        eps_rms_without: s.possible.as_ref().map(|r| r.summary.eps_rms),
        outcome: s.outcome(),
        eps_max_before: s.before.summary.eps_max,
        eps_max_after: s.after.summary.eps_max,
        remains: Improvement::named(&s.remains),
        found_first: Improvement::named(&s.first),
        designed: s.designed.iter().map(|d| &d.next).collect(),
        changes: &s.changes,
        diagnosis: &s.diagnosis,
    }
}

/// The files written for the tests.
fn written(tests: &[PathBuf]) -> Vec<String> {
    let designed =
        (1..=DESIGNED).flat_map(|n| [format!("designed-{n}.csv"), format!("next-{n}.csv")]);
    let endings: Vec<String> = ["model.toml", "record.csv"]
        .map(str::to_owned)
        .into_iter()
        .chain(designed)
        .collect();
    let of_tests = tests.iter().flat_map(|test| {
        let name = stem(test);
        endings.iter().map(move |ending| format!("{name}-{ending}"))
    });
    ["report.html", "summary.json"]
        .map(str::to_owned)
        .into_iter()
        .chain(of_tests)
        .collect()
}

/// The common beginning of a test's file names.
fn stem(test: &Path) -> String {
    let stem = test.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

/// The files besides the page.
fn files_of(improvements: &[(String, &Improvement)]) -> Result<Vec<(String, String)>, Failure> {
    let mut files = Vec::new();
    for (name, improvement) in improvements {
        let improved: &Model = &improvement.diagnosis.improved;
        // A model that made the test worse is not written.
        if improvement.outcome() != ImprovementOutcome::Worse {
            files.push((format!("{name}-model.toml"), model::to_toml(improved)?));
        }
        if let Some(trace) = &improvement.before.trace {
            files.push((format!("{name}-record.csv"), record_csv::to_csv(trace)));
        }
        for (i, d) in improvement.designed.iter().enumerate() {
            let number = i + 1;
            files.push((
                format!("{name}-designed-{number}.csv"),
                d.played.text.clone(),
            ));
            files.push((
                format!("{name}-next-{number}.csv"),
                designed_test::text(&d.next),
            ));
        }
    }
    Ok(files)
}
