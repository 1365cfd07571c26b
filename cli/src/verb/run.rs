//! `outerloop run`: one closed-loop test.

use super::place::Place;
use super::{Common, json, method};
use crate::failure::Failure;
use crate::files::{model, output, record_csv};
use crate::improvement;
use crate::report::{self, Section};
use crate::story::Site;
use crate::terminal::{self, Progress};
use std::path::PathBuf;

/// One closed-loop test
#[derive(clap::Args, Debug)]
pub struct Run {
    #[command(flatten)]
    common: Common,
    /// The ground motion: CSV, AT2, or one acceleration a line
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// The compensation, instead of the test file's
    #[arg(long, value_name = "NAME")]
    compensation: Option<String>,
    /// Write report.html, record.csv and summary.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// What is known of the rig, for example from `diagnose --save-model`: taken into account in this test
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    #[command(flatten)]
    place: Place,
}

impl Run {
    /// Runs the test.
    ///
    /// # Errors
    /// Bad input, or a test that tripped, ran away, or is not the structure's response.
    pub fn go(&self) -> Result<(), Failure> {
        let mut test = self.common.load()?;
        if let Some(told) = test.told_the_truth().filter(|_| !self.common.json) {
            println!("{told}");
        }
        if let Some(path) = &self.model {
            for done in improvement::apply(&model::load(path)?, &mut test.config) {
                if !self.common.json {
                    println!("{}: {done}", path.display());
                }
            }
        }
        let kind = match &self.compensation {
            Some(name) => method(name)?,
            None => test.config.compensation.kind,
        };
        let experiment = self.common.experiment(&test, self.record.as_deref())?;
        let run = {
            let progress = Progress::over(&experiment.record, experiment.control_steps() as u64);
            let ideal = experiment.ideal()?;
            let keep = self.out.is_some();
            let tell = progress.witness();
            let seed = self.common.seed;
            let run = self
                .place
                .run(&experiment, kind, &ideal, seed, keep, tell)?;
            if let (Some(folder), Some(trace)) = (&self.out, &run.trace) {
                let section = Section {
                    experiment: &experiment,
                    summary: &run.summary,
                    trace,
                    ideal: &ideal,
                };
                output::write_all(
                    folder,
                    &[
                        ("report.html", report::of_run(&section)?),
                        ("record.csv", record_csv::to_csv(trace)),
                        ("summary.json", json(&run.summary)?),
                    ],
                )?;
            }
            run
        };
        if self.common.json {
            println!("{}", json(&run.summary)?);
        } else {
            println!("{}", experiment.in_words());
            for remark in experiment.remarks() {
                println!("{remark}");
            }
            println!(
                "{}",
                terminal::summaries(std::slice::from_ref(&run.summary))
            );
            // A test that failed says so once, at the end.
            if run.summary.outcome().is_ok() {
                println!("{}", run.summary.sentence());
            }
            if let Some(folder) = &self.out {
                println!("Look at {}", folder.join("report.html").display());
            }
        }
        if let Some(board) = run.summary.board.as_ref().filter(|_| !self.common.json) {
            println!("{}", board.sentence());
        }
        run.summary.outcome()
    }
}
