//! `outerloop compare`: the same test under several compensations, one row each.

use super::diff::Diff;
use super::{CommonArguments, MethodName, each_record, hand_over_tests, no_files, require_all_ran};
use crate::answer::{TestSection, of_compare};
use crate::provenance::WithProvenance;
use crate::terminal::{Progress, interrupt};
use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::summary::{Summary, Validity};
use rayon::prelude::*;
use std::path::PathBuf;

/// Run the same test under several compensations; or compare two tests that ran
#[derive(clap::Args, Debug)]
pub struct Compare {
    #[command(flatten)]
    common: CommonArguments,
    /// A second recorded test: does the same as `diff`. Both are then the folder of `run --out`, its record.h5 or an archive
    #[arg(value_name = "SECOND", conflicts_with_all = ["record", "compensations", "duration", "overrides"])]
    second: Option<PathBuf>,
    /// A ground motion; may be given several times
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,
    /// Compensations, separated by commas; left out: all
    #[arg(long, value_delimiter = ',', value_name = "A,B,...", value_parser = MethodName, hide_possible_values = true)]
    compensations: Vec<String>,
    /// Write report.html and compare.json, the rows, there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Compare {
    /// Runs every pair of record and compensation, on all cores.
    ///
    /// # Errors
    /// Bad input; no row that is the structure's response.
    pub fn run(&self) -> Result<(), Failure> {
        if let Some(second) = &self.second {
            let tests = [&self.common.test, second].map(PathBuf::clone);
            return Diff::of(tests, self.out.clone(), self.common.json).run();
        }
        interrupt::watch();
        let out = look_ahead::folder(self.out.as_deref(), &["report.html", "compare.json"])?;
        let out = out.as_deref();
        let test = self.common.load_any()?;
        let all = Compensation::all(test.coupled.is_some());
        let methods = test.compensations(&self.compensations, all)?;
        let experiments = self.experiments(&test)?;
        let steps: usize = experiments.iter().map(Experiment::control_steps).sum();
        let ideals = experiments
            .par_iter()
            .map(Experiment::ideal)
            .collect::<Result<Vec<_>, _>>()?;
        let runs: Vec<(usize, JudgedRun)> = {
            let progress = Progress::over("compare", (steps * methods.len()) as u64);
            let tests: Vec<(usize, Compensation)> = (0..experiments.len())
                .flat_map(|e| methods.iter().map(move |m| (e, *m)))
                .collect();
            let keep = out.is_some();
            tests
                .into_par_iter()
                .filter(|_| !interrupt::asked())
                .map(|(e, method)| {
                    let (seed, observer) = (self.common.seed, progress.observer());
                    let run = experiments[e].run(method, &ideals[e], seed, keep, observer)?;
                    Ok((e, run))
                })
                .collect::<Result<_, Failure>>()?
        };
        let rows: Vec<Summary> = runs.iter().map(|(_, run)| run.summary.clone()).collect();
        let all = serde_json::json!({ "rows": rows });
        let asked = experiments.len() * methods.len();
        hand_over_tests(
            (rows.len(), asked),
            (out, self.common.json),
            no_files,
            |_| {
                let kept = runs.iter().filter_map(|(e, run)| {
                    Some(TestSection {
                        experiment: &experiments[*e],
                        summary: &run.summary,
                        trace: run.trace.as_ref()?,
                        ideal: &ideals[*e],
                    })
                });
                of_compare(&rows, &kept.collect::<Vec<_>>()).with_figures(
                    "compare.json",
                    &WithProvenance::seeded(&all, self.common.seed),
                )
            },
        )?;
        require_all_ran(rows.len(), asked)?;
        // Comparisons exist to show rows that ran away; but at least one row must be usable.
        if rows.iter().all(|r| r.validity() == Validity::Bad) {
            return Err(Failure::test(
                "no compensation gave the structure's response in this test",
            ));
        }
        Ok(())
    }

    /// The test with each ground motion.
    fn experiments(&self, test: &TestFile) -> Result<Vec<Experiment>, Failure> {
        each_record(&self.record)
            .into_iter()
            .map(|file| self.common.experiment(test, file))
            .collect()
    }
}
