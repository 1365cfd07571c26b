//! `outerloop demo`: the whole story with no input.

use super::seconds;
use crate::bench::{run_ideal, run_on_plant};
use crate::failure::Failure;
use crate::files::near_fault::near_fault;
use crate::files::output;
use crate::files::test::TestFile;
use crate::report::{self, Section};
use crate::summary::Summary;
use crate::terminal;
use outerloop_core::Method;
use std::path::{Path, PathBuf};

/// The whole story with no input, on a built-in near-fault record
#[derive(clap::Args, Debug)]
pub struct Demo {
    /// Where report.html goes
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
}

/// The test of Table 1, as the examples have it.
const TEST: &str = include_str!("../../../examples/table1.toml");

impl Demo {
    /// Runs the demonstration.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn go(&self) -> Result<(), Failure> {
        let table = TEST
            .parse()
            .map_err(|e| Failure::Test(format!("examples/table1.toml: {e}")))?;
        let test = TestFile::from_table(table, "examples/table1.toml", Path::new(""))?;
        let shaking = near_fault();
        let seconds = seconds(None, &shaking)?;
        println!(
            "A structure of {} kg on {} kN/m, an actuator {} ms late, {seconds:.0} s of a near-fault ground motion.\n",
            test.config.structure.mass_kg[0],
            test.config.structure.stiffness_n_per_m[0] / 1e3,
            test.config.compensation.delay_ms,
        );
        let ideal = run_ideal(&test, &shaking, seconds)?;
        let mut tests = Vec::new();
        for kind in Method::ALL {
            let mut test = test.clone();
            test.config.compensation.kind = kind;
            let run = run_on_plant(&test, &shaking, seconds, 1, &|_| ())?;
            let summary = Summary::of(&test, &shaking.name, &run, &ideal);
            tests.push((test, run, summary));
        }
        let rows: Vec<Summary> = tests.iter().map(|t| t.2.clone()).collect();
        println!("{}\n", terminal::summaries(&rows));
        for row in &rows {
            println!("{:15} {}", row.compensation, row.sentence());
        }
        let section = |kind| {
            let (test, run, summary) = tests
                .iter()
                .find(|t| t.0.config.compensation.kind == kind)?;
            Some(Section {
                test,
                summary,
                run,
                ideal: &ideal,
            })
        };
        if let (Some(none), Some(paper)) = (section(Method::None), section(Method::Paper)) {
            let page = report::of_demo(&none, &paper, &rows)?;
            output::write_all(&self.out, &[("report.html", page)])?;
            println!("\nLook at {}", self.out.join("report.html").display());
        }
        Ok(())
    }
}
