//! `outerloop demo`: every method on one test, then a test, its diagnosis and the repeated test, with no input.

use super::look_at_page;
use crate::answer::{TestSection, of_demo};
use crate::improve::{FirstTest, Improvement};
use crate::terminal::Progress;
use crate::verb::rig_arguments::RigArguments;
use experiment::Experiment;
use experiment::failure::Failure;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::files::{look_ahead, output};
use experiment::summary::Summary;
use outerloop_core::Method;
use std::path::{Path, PathBuf};

/// Show a whole test without any input, on a built-in near-fault record
#[derive(clap::Args, Debug)]
pub struct Demo {
    /// Where report.html goes
    #[arg(long, value_name = "DIR", default_value = "out/demo")]
    out: PathBuf,
}

/// The test of Table 1, as in the examples.
const TEST: &str = include_str!("../../../examples/table1.toml");
const SEED: u64 = 1;

/// The test whose rig has something undeclared, as in the examples.
const UNDECLARED: &str = include_str!("../../../examples/undeclared/inertia.toml");

/// A test, the diagnosis of its record, and the improved test.
fn undeclared() -> Result<Improvement, Failure> {
    let file = "examples/undeclared/inertia.toml";
    let test = TestFile::parse(UNDECLARED, file, Path::new(""), &[])?;
    let model = test
        .declared_model()
        .ok_or_else(|| Failure::test(format!("{file}: declares no model")))?;
    let experiment = Experiment::new(test, &near_fault(), None)?;
    let progress = Progress::over(
        "tests and diagnosis",
        Improvement::steps(&experiment) as u64,
    );
    let rig = RigArguments::default();
    let first = FirstTest::run(experiment, &rig, SEED, &progress)?;
    Improvement::of(first, &model, &rig, SEED, &progress)
}

impl Demo {
    /// Runs the demonstration.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub fn run(&self) -> Result<(), Failure> {
        let names = ["report.html"];
        let out = look_ahead::folder(Some(&self.out), &names)?;
        let out = out.as_deref().unwrap_or(&self.out);
        let test = TestFile::parse(TEST, "examples/table1.toml", Path::new(""), &[])?;
        let experiment = Experiment::new(test, &near_fault(), None)?;
        let steps = experiment.control_steps() * Method::ALL.len();
        let ideal = experiment.ideal()?;
        let runs = {
            let progress = Progress::over("tests", steps as u64);
            Method::ALL
                .into_iter()
                .map(|kind| experiment.run(kind, &ideal, SEED, true, progress.observer()))
                .collect::<Result<Vec<_>, _>>()?
        };
        let rows: Vec<Summary> = runs.iter().map(|r| r.summary.clone()).collect();
        let section = |kind: Method| {
            let run = runs
                .iter()
                .find(|r| r.summary.compensation == kind.name())?;
            Some(TestSection {
                experiment: &experiment,
                summary: &run.summary,
                trace: run.trace.as_ref()?,
                ideal: &ideal,
            })
        };
        let improvement = undeclared()?;
        if let (Some(none), Some(paper)) = (section(Method::None), section(Method::Paper)) {
            let document = of_demo(&none, &paper, &rows, &improvement);
            output::write_all(out, &[("report.html", document.page())])?;
            println!("{}", document.terminal());
            look_at_page(Some(out));
        }
        Ok(())
    }
}
