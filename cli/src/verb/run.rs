//! `outerloop run`: one closed-loop test.

use super::{Common, json, method};
use crate::board::emulated::{Emulated, Laboratory};
use crate::board::{BoardBench, Connection, Patience, Port, Serial};
use crate::experiment::{self, Experiment};
use crate::failure::Failure;
use crate::files::{output, record_csv};
use crate::report::{self, Section};
use crate::summary::Verdict;
use crate::terminal::{self, Progress};
use crate::trace::{Response, Witness};
use outerloop_core::Method;
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
    /// Run on the board at this serial port instead of the simulated rig
    #[arg(long, value_name = "DEV", conflicts_with = "emulated")]
    port: Option<String>,
    /// Run on an emulated board: the image as it is flashed, with the simulated rig behind its converters
    #[arg(long)]
    emulated: bool,
}

impl Run {
    /// Runs the test.
    ///
    /// # Errors
    /// Bad input, or a test that tripped.
    pub fn go(&self) -> Result<(), Failure> {
        let test = self.common.load()?;
        let kind = match &self.compensation {
            Some(name) => method(name)?,
            None => test.config.compensation.kind,
        };
        let experiment = self.common.experiment(&test, self.record.as_deref())?;
        let run = {
            let progress = Progress::over(&experiment.record, experiment.control_steps() as u64);
            let ideal = experiment.ideal()?;
            let keep = self.out.is_some();
            let run = self.on_its_bench(&experiment, kind, &ideal, keep, progress.witness())?;
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
            println!(
                "{}",
                terminal::summaries(std::slice::from_ref(&run.summary))
            );
            if run.summary.verdict != Verdict::Tripped {
                println!("{}", run.summary.sentence());
            }
            if let Some(folder) = &self.out {
                println!("Look at {}", folder.join("report.html").display());
            }
        }
        if let Some(board) = run.summary.board.as_ref().filter(|_| !self.common.json) {
            println!("{}", board.sentence());
        }
        match run.summary.verdict {
            Verdict::Tripped => Err(Failure::test(run.summary.sentence())),
            Verdict::Completed | Verdict::Diverged => Ok(()),
        }
    }

    /// Runs the test where it was asked for.
    fn on_its_bench(
        &self,
        experiment: &Experiment,
        method: Method,
        ideal: &Response,
        keep: bool,
        tell: impl Witness,
    ) -> Result<experiment::Run, Failure> {
        let connection = if let Some(device) = &self.port {
            let port: Box<dyn Port> = Box::new(Serial::open(device)?);
            Connection::new(port, Patience::BOARD)
        } else if self.emulated {
            let laboratory = Laboratory::of(&experiment.test, self.common.seed);
            let port: Box<dyn Port> = Box::new(Emulated::start(&laboratory)?);
            Connection::new(port, Patience::EMULATED)
        } else {
            return experiment.run(method, ideal, self.common.seed, keep, tell);
        };
        experiment.run_on(&BoardBench::new(connection), method, ideal, keep, tell)
    }
}
