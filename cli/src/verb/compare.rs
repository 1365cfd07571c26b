//! `outerloop compare`: the same test under several compensations, one row each.

use super::{CommonArguments, MethodName, each_record, hand_over, json, require_all_ran};
use crate::comparison::condition::{Condition, yielding};
use crate::comparison::{self, standing};
use crate::provenance::WithProvenance;
use crate::report::{self, TestSection};
use crate::terminal::{self, Progress, interrupt};
use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::method;
use experiment::summary::{Summary, Validity};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Run the same test under several compensations
#[derive(clap::Args, Debug)]
pub struct Compare {
    #[command(flatten)]
    common: CommonArguments,
    /// A ground motion; may be given several times
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,
    /// Compensations, separated by commas; left out: all
    #[arg(long, value_delimiter = ',', value_name = "A,B,...", value_parser = MethodName, hide_possible_values = true)]
    compensations: Vec<String>,
    /// The same on the bench: delays of 1 to 60 ms, several actuators and specimens, noise, and wrong declarations to
    /// the compensation, in place of the test file's rig
    #[arg(long)]
    bench: bool,
    /// Write report.html there, and the rows as compare.json, or as bench.json with --bench
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Compare {
    /// Runs every pair of record and compensation, on all cores.
    ///
    /// # Errors
    /// Bad input; no row that is the structure's response.
    pub fn run(&self) -> Result<(), Failure> {
        interrupt::watch();
        let name = if self.bench {
            "bench.json"
        } else {
            "compare.json"
        };
        let out = look_ahead::folder(self.out.as_deref(), &["report.html", name])?;
        let out = out.as_deref();
        let test = self.common.load_any()?;
        if test.coupled.is_some() {
            super::coupled::refuse(&[("--bench", self.bench)])?;
        }
        if self.bench {
            return self.compare_conditions(out);
        }
        let methods = match &self.compensations[..] {
            [] => Compensation::all(test.coupled.is_some()),
            names => {
                let named = names.iter().map(|n| test.compensation_named(n));
                named.collect::<Result<_, _>>()?
            }
        };
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
        let page = || {
            let sections: Vec<TestSection<'_>> = runs
                .iter()
                .filter_map(|(e, run)| {
                    Some(TestSection {
                        experiment: &experiments[*e],
                        summary: &run.summary,
                        trace: run.trace.as_ref()?,
                        ideal: &ideals[*e],
                    })
                })
                .collect();
            Ok(vec![("report.html", report::of_compare(&sections))])
        };
        hand_over(
            (out, self.common.json),
            (
                "compare.json",
                &json(&WithProvenance::seeded(&all, self.common.seed))?,
            ),
            page,
            || println!("{}", terminal::summaries(&rows)),
        )?;
        require_all_ran(rows.len(), experiments.len() * methods.len())?;
        // A row that ran away is what a comparison is for; one without any usable row is not.
        if rows.iter().all(|r| r.validity() == Validity::Bad) {
            return Err(Failure::test(
                "no compensation gave the structure's response in this test",
            ));
        }
        Ok(())
    }

    /// The test on each ground motion.
    fn experiments(&self, test: &TestFile) -> Result<Vec<Experiment>, Failure> {
        each_record(&self.record)
            .into_iter()
            .map(|file| self.common.experiment(test, file))
            .collect()
    }

    /// Every contestant under every condition of the bench.
    fn compare_conditions(&self, out: Option<&Path>) -> Result<(), Failure> {
        let test = self.common.load()?;
        let contestants = match &self.compensations[..] {
            [] => comparison::contestants(),
            names => names.iter().map(|n| method(n)).collect::<Result<_, _>>()?,
        };
        let experiments = self.experiments(&test)?;
        let conditions = Condition::all(&test.config, &yielding(&test.plant.specimen));
        let began = Instant::now();
        let rows = comparison::run(&experiments, &conditions, &contestants, self.common.seed)?;
        let lead = format!(
            "{} tests: {} compensations, {} rigs, {}; {:.0} s on {} threads.",
            rows.len(),
            contestants.len(),
            conditions.len(),
            experiments
                .iter()
                .map(|e| format!("{:.0} s of {}", e.seconds, e.record))
                .collect::<Vec<_>>()
                .join(", "),
            began.elapsed().as_secs_f64(),
            rayon::current_num_threads(),
        );
        let standings = standing::of(&rows);
        let all = serde_json::json!({ "rows": rows, "standings": standings });
        hand_over(
            (out, self.common.json),
            ("bench.json", &json(&WithProvenance::of(&all))?),
            || Ok(vec![("report.html", report::of_comparison(&rows, &lead))]),
            || {
                println!("{lead} Geometric means of eps_rms, Eq 18.\n");
                println!("{}", terminal::standings(&standings));
            },
        )?;
        require_all_ran(
            rows.len(),
            experiments.len() * conditions.len() * contestants.len(),
        )
    }
}
