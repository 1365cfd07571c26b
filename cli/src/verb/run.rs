//! `outerloop run`: one closed-loop test.

use super::{Common, method};
use crate::bench::{run_ideal, run_on_plant};
use crate::failure::Failure;
use crate::files::{output, record};
use crate::report::{self, Section};
use crate::summary::{Summary, Verdict};
use crate::terminal;
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
}

impl Run {
    /// Runs the test.
    ///
    /// # Errors
    /// Bad input, or a test that tripped.
    pub fn go(&self) -> Result<(), Failure> {
        let mut test = self.common.load()?;
        if let Some(name) = &self.compensation {
            test.config.compensation.kind = method(name)?;
        }
        let shaking = self.common.shaking(&test, self.record.as_deref())?;
        let seconds = self.common.seconds(&test, &shaking)?;
        let bar = terminal::progress(&shaking.name, 1000);
        let ideal = run_ideal(&test, &shaking, seconds)?;
        let run = run_on_plant(&test, &shaking, seconds, self.common.seed, &|share| {
            bar.set_position((share * 1000.0) as u64);
        })?;
        bar.finish_and_clear();
        let summary = Summary::of(&test, &shaking.name, &run, &ideal);
        let json = serde_json::to_string_pretty(&summary)
            .map_err(|e| Failure::Test(format!("the summary cannot be written as JSON: {e}")))?;
        if let Some(folder) = &self.out {
            let section = Section {
                test: &test,
                summary: &summary,
                run: &run,
                ideal: &ideal,
            };
            let page = report::of_run(&section)?;
            output::write_all(
                folder,
                &[
                    ("report.html", page),
                    ("record.csv", record::to_csv(&run.trace)),
                    ("summary.json", json.clone()),
                ],
            )?;
        }
        if self.common.json {
            println!("{json}");
        } else {
            println!("{}", terminal::summaries(std::slice::from_ref(&summary)));
            println!("{}", summary.sentence());
            if let Some(folder) = &self.out {
                println!("{}", folder.join("report.html").display());
            }
        }
        match summary.verdict {
            Verdict::Tripped => Err(Failure::Test(summary.sentence())),
            _ => Ok(()),
        }
    }
}
