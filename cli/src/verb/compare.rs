//! `outerloop compare`: the same test under several compensations, one row each.

use super::{Common, json, method};
use crate::experiment::Experiment;
use crate::failure::Failure;
use crate::summary::Summary;
use crate::terminal::{self, Progress};
use outerloop_core::Method;
use rayon::prelude::*;
use std::path::PathBuf;

/// The same test under several compensations
#[derive(clap::Args, Debug)]
pub struct Compare {
    #[command(flatten)]
    common: Common,
    /// A ground motion; may be given several times
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,
    /// Compensations, separated by commas; left out: all
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    compensations: Vec<String>,
}

impl Compare {
    /// Runs every pair of record and compensation, on all cores.
    ///
    /// # Errors
    /// Bad input.
    pub fn go(&self) -> Result<(), Failure> {
        let test = self.common.load()?;
        let methods = match &self.compensations[..] {
            [] => Method::ALL.to_vec(),
            names => names.iter().map(|n| method(n)).collect::<Result<_, _>>()?,
        };
        let experiments: Vec<Experiment> = match &self.record[..] {
            [] => vec![self.common.experiment(&test, None)?],
            files => files
                .iter()
                .map(|f| self.common.experiment(&test, Some(f)))
                .collect::<Result<_, _>>()?,
        };
        let steps: usize = experiments.iter().map(Experiment::control_steps).sum();
        let rows = {
            let progress = Progress::over("compare", (steps * methods.len()) as u64);
            let rows: Vec<Vec<Summary>> = experiments
                .par_iter()
                .map(|e| {
                    let ideal = e.ideal()?;
                    let run = |kind: &Method| {
                        e.run(*kind, &ideal, self.common.seed, false, progress.witness())
                            .map(|run| run.summary)
                    };
                    methods.par_iter().map(run).collect()
                })
                .collect::<Result<_, Failure>>()?;
            rows.concat()
        };
        if self.common.json {
            println!("{}", json(&serde_json::json!({ "rows": rows }))?);
        } else {
            println!("{}", terminal::summaries(&rows));
        }
        Ok(())
    }
}
