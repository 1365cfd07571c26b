//! `run`, `compare` and `check` of a test of two coupled actuators.

use super::rig_arguments::RigKind;
use super::{CommonArguments, each_record, hand_over, json};
use crate::archive::{self, FinishedTest};
use crate::provenance::WithProvenance;
use crate::report::{self, CoupledSection};
use crate::terminal::coupled_test::{
    FOUND_HEAD, LEAST_IMPORTANT, LEGEND, LIMIT_HEAD, SUMMARY_HEAD, found_row, limit_row,
    summary_row,
};
use crate::terminal::{self, Progress, plot, table};
use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::coupled::planned::{self, CoupledCheck};
use experiment::coupled::summary::CoupledSummary;
use experiment::coupled::table::CoupledCompensation;
use experiment::coupled::trace::CoupledTrace;
use experiment::coupled::trial::{self, Trial};
use experiment::failure::Failure;
use experiment::files::ground_motion::GroundMotionFile;
use experiment::files::output;
use experiment::files::test::TestFile;
use experiment::numbers::{percent, si};
use experiment::stability::perturbed::Spread;
use experiment::summary::Validity;
use experiment::trace::Response;
use rayon::prelude::*;
use std::path::{Path, PathBuf};

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

/// A compensation by its name; left out: the test's own.
fn kind(test: &TestFile, name: Option<&str>) -> Result<CoupledCompensation, Failure> {
    let asked = match name {
        Some(name) => test.compensation_named(name)?,
        None => test.compensation(),
    };
    match asked {
        Compensation::Coupled(kind) => Ok(kind),
        Compensation::Method(_) => Ok(test.coupled_part()?.declared.compensation),
    }
}

/// What is asked of one test.
pub(super) struct CoupledRequest<'a> {
    /// What all verbs have in common.
    pub common: &'a CommonArguments,
    /// The ground motion.
    pub record: Option<&'a Path>,
    /// The compensation, instead of the file's.
    pub compensation: Option<&'a str>,
    /// Where results go.
    pub out: Option<&'a Path>,
    /// The archive.
    pub archive: Option<&'a Path>,
    /// True if the picture is wanted, terminal or not.
    pub plot: bool,
}

/// One test.
///
/// # Errors
/// Bad input, or a test that tripped, ran away, or is not the structure's response.
pub(super) fn run(test: &TestFile, asked: &CoupledRequest<'_>) -> Result<(), Failure> {
    let kind = kind(test, asked.compensation)?;
    let common = asked.common;
    let experiment = common.experiment(test, asked.record)?;
    let keep = asked.out.is_some() || asked.archive.is_some();
    let (ideal, trial) = terminal::while_waiting(&experiment.record, || {
        let ideal = experiment.ideal()?;
        let trial = trial::run(&experiment, kind, &ideal, common.seed, keep)?;
        Ok::<_, Failure>((ideal, trial))
    })?;
    let summary = CoupledSummary::of(&experiment, kind, &trial)?;
    let archived = match &trial.run.trace {
        None => Vec::new(),
        Some(trace) => archive::to_bytes(&FinishedTest {
            experiment: &experiment,
            compensation: kind.into(),
            place: RigKind::Simulated,
            seed: common.seed,
            orders: &[],
            summary: &trial.run.summary,
            trace,
        })?,
    };
    if let Some(file) = asked.archive {
        output::write(file, &archived)?;
    }
    let files = || {
        let page = report::of_coupled_run(&CoupledSection {
            experiment: &experiment,
            summary: &summary,
            record: &trial.record,
            ideal: &ideal,
        });
        Ok(vec![
            ("report.html", page.into_bytes()),
            ("record.csv", trial.record.to_csv().into_bytes()),
            ("record.h5", archived.clone()),
        ])
    };
    let print = || {
        println!("{}", in_words(&experiment, &summary));
        print(std::slice::from_ref(&summary));
        if !summary.found.is_empty() {
            let mut found = table(&FOUND_HEAD);
            found.add_rows(summary.found.iter().map(found_row));
            println!("{found}\n");
        }
        if asked.plot || plot::columns().is_some() {
            println!("{}\n", picture(&experiment, &ideal, &trial.record));
        }
        if summary.outcome().is_ok() {
            println!("{}", summary.sentence());
        }
    };
    let text = json(&WithProvenance::seeded(&summary, common.seed))?;
    hand_over(
        (asked.out, common.json),
        ("summary.json", &text),
        files,
        print,
    )?;
    summary.outcome()
}

fn in_words(e: &Experiment, s: &CoupledSummary) -> String {
    let hz: Vec<String> = s
        .natural_frequencies_hz
        .iter()
        .map(|hz| experiment::numbers::three(*hz))
        .collect();
    format!(
        "{} of {}, on a structure of {} Hz that two coupled actuators move in x and in rotation (a simulated rig).",
        si(e.seconds, "s"),
        e.record,
        hz.join(", ")
    )
}

fn print(rows: &[CoupledSummary]) {
    for group in rows.chunk_by(|a, b| a.record == b.record) {
        if group.len() < rows.len() {
            println!("{}", group[0].record);
        }
        let mut t = table(&SUMMARY_HEAD).least_important(&LEAST_IMPORTANT);
        t.add_rows(group.iter().map(summary_row));
        println!("{t}");
    }
    println!("{LEGEND}\n");
}

/// x of the interface in the terminal.
fn picture(e: &Experiment, ideal: &Response, record: &CoupledTrace) -> String {
    let of = |x: &[f32]| {
        let mut response = Response::new(1);
        x.iter().for_each(|u| response.push(&[*u]));
        response
    };
    plot::response(
        &of(&ideal.floor(0).collect::<Vec<_>>()),
        &of(&record.target[0]),
        e.test.config.model_step_s(),
    )
}

/// The same test under several compensations.
///
/// # Errors
/// Bad input; no row that is the structure's response.
pub(super) fn compare(
    test: &TestFile,
    common: &CommonArguments,
    (records, names): (&[PathBuf], &[String]),
    out: Option<&Path>,
) -> Result<(), Failure> {
    let kinds = match names {
        [] => CoupledCompensation::ALL.to_vec(),
        names => names
            .iter()
            .map(|n| kind(test, Some(n)))
            .collect::<Result<_, _>>()?,
    };
    let experiments = each_record(records)
        .into_iter()
        .map(|file| common.experiment(test, file))
        .collect::<Result<Vec<_>, _>>()?;
    let ideals = experiments
        .iter()
        .map(Experiment::ideal)
        .collect::<Result<Vec<_>, _>>()?;
    let pairs: Vec<(usize, CoupledCompensation)> = (0..experiments.len())
        .flat_map(|e| kinds.iter().map(move |k| (e, *k)))
        .collect();
    let progress = Progress::over("compare", pairs.len() as u64);
    let runs: Vec<(usize, CoupledSummary, Trial)> = pairs
        .into_par_iter()
        .map(|(e, kind)| {
            let trial = trial::run(&experiments[e], kind, &ideals[e], common.seed, false)?;
            let summary = CoupledSummary::of(&experiments[e], kind, &trial)?;
            progress.add(1);
            Ok((e, summary, trial))
        })
        .collect::<Result<_, Failure>>()?;
    drop(progress);
    let rows: Vec<CoupledSummary> = runs.iter().map(|(_, s, _)| s.clone()).collect();
    let all = serde_json::json!({ "rows": rows });
    let page = || {
        let sections: Vec<CoupledSection<'_>> = runs
            .iter()
            .map(|(e, summary, trial)| CoupledSection {
                experiment: &experiments[*e],
                summary,
                record: &trial.record,
                ideal: &ideals[*e],
            })
            .collect();
        Ok(vec![("report.html", report::of_coupled_compare(&sections))])
    };
    let text = json(&WithProvenance::seeded(&all, common.seed))?;
    hand_over((out, common.json), ("compare.json", &text), page, || {
        print(&rows)
    })?;
    if rows.iter().all(|r| r.validity() == Validity::Bad) {
        return Err(Failure::test(
            "no compensation gave the structure's response in this test",
        ));
    }
    Ok(())
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
    let kind = kind(test, asked.compensation)?;
    let experiment = Experiment::new(test.clone(), &asked.shaking, None)?;
    let (check, ideal, trial) = {
        let progress = Progress::over("rigs", asked.spread.plants as u64);
        planned::check(&experiment, kind, &asked.spread, || progress.add(1))?
    };
    let page = || {
        let section = CoupledSection {
            experiment: &experiment,
            summary: &check.planned,
            record: &trial.record,
            ideal: &ideal,
        };
        let page = report::of_coupled_check(&check, &section);
        Ok(vec![("report.html", page)])
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
    println!("{}", in_words(experiment, &check.planned));
    let mut limits = table(&LIMIT_HEAD);
    limits.add_rows(check.limits.iter().map(limit_row));
    println!(
        "{limits}\n\n{} of {} rigs that differ are lost.",
        check.lost, check.plants,
    );
}
