//! `outerloop compare`: the same test under several compensations, one row each.

use super::{Common, method};
use crate::bench::{run_ideal, run_on_plant};
use crate::failure::Failure;
use crate::summary::Summary;
use crate::terminal;
use outerloop_core::Method;
use rayon::prelude::*;
use std::path::PathBuf;

/// The same test under several compensations
#[derive(clap::Args, Debug)]
pub struct Compare {
    #[command(flatten)]
    common: Common,
    /// Ground motions; several may be given
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
        let methods = if self.compensations.is_empty() {
            Method::ALL.to_vec()
        } else {
            self.compensations
                .iter()
                .map(|n| method(n))
                .collect::<Result<_, _>>()?
        };
        let records = match &self.record[..] {
            [] => vec![self.common.shaking(&test, None)?],
            files => files
                .iter()
                .map(|f| self.common.shaking(&test, Some(f)))
                .collect::<Result<_, _>>()?,
        };
        let bar = terminal::progress("tests", (records.len() * methods.len()) as u64);
        let rows: Vec<Vec<Summary>> = records
            .par_iter()
            .map(|shaking| {
                let seconds = self.common.seconds(&test, shaking)?;
                let ideal = run_ideal(&test, shaking, seconds)?;
                methods
                    .par_iter()
                    .map(|&kind| {
                        let mut test = test.clone();
                        test.config.compensation.kind = kind;
                        let run = run_on_plant(&test, shaking, seconds, self.common.seed, &|_| ())?;
                        bar.inc(1);
                        Ok(Summary::of(&test, &shaking.name, &run, &ideal))
                    })
                    .collect()
            })
            .collect::<Result<_, Failure>>()?;
        bar.finish_and_clear();
        let rows = rows.concat();
        if self.common.json {
            println!("{}", serde_json::json!({ "rows": rows }));
        } else {
            println!("{}", terminal::summaries(&rows));
        }
        Ok(())
    }
}
