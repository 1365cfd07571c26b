//! One file per verb.

pub mod benchmark;
pub mod board;
pub mod check;
pub mod compare;
pub(crate) mod coupled;
pub mod demo;
pub mod diagnose;
pub mod diff;
pub mod effects;
pub mod help;
pub mod identify;
pub mod improve;
pub mod keys;
pub mod new;
pub mod replay;
pub mod rig_arguments;
pub mod run;
pub mod serve;
pub mod shell;
pub mod sweep;

use crate::document::Document;
use crate::provenance::note_seed;
use clap::builder::{PossibleValue, StringValueParser, TypedValueParser};
use experiment::Experiment;
use experiment::failure::Failure;
use experiment::files::ground_motion::{AccelerationUnit, ColumnChoice, GroundMotionFile};
use experiment::files::near_fault::near_fault;
use experiment::files::output;
use experiment::files::test::{Excitation, TestFile};
use outerloop_core::Method;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

/// What is said on the command line of a ground motion that does not say it itself.
#[derive(clap::Args, Debug)]
pub struct MotionArguments {
    /// Sampling interval, s, of a ground motion file with one acceleration per line
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    dt: Option<f64>,
    /// Unit of the accelerations in that file
    #[arg(long, value_name = "UNIT")]
    unit: Option<AccelerationUnit>,
}

impl MotionArguments {
    /// The ground motion: the one named here, else the test's, else the built-in one.
    fn shaking(
        &self,
        named: Option<&Path>,
        of_test: &Excitation,
    ) -> Result<GroundMotionFile, Failure> {
        let columns = ColumnChoice {
            interval_s: self.dt,
            unit: self.unit,
        };
        match named.or(of_test.record.as_deref()) {
            Some(path) => GroundMotionFile::load(path, columns),
            None if self.dt.is_some() || self.unit.is_some() => Err(Failure::input(
                "--dt and --unit tell how a file is read, and the ground motion is the built-in one: accepted are they beside \
                 --record FILE, or with a test file whose excitation.record names one",
            )),
            None => Ok(near_fault()),
        }
    }
}

/// What `run` and `compare` have in common.
#[derive(clap::Args, Debug)]
pub struct CommonArguments {
    /// The test file
    test: PathBuf,
    #[command(flatten)]
    motion: MotionArguments,
    /// Override a value of the test file, e.g. plant.actuator.delay_ms=8
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Seconds of model time; left out: as the test file says, else the whole record
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl CommonArguments {
    /// The test file, with `[coupled]` or without.
    fn load_any(&self) -> Result<TestFile, Failure> {
        note_seed(self.seed);
        TestFile::load_any(&self.test, &self.overrides)
    }

    /// The test file, with `[coupled]` or without, and with one more override.
    fn load_with(&self, assignment: &str) -> Result<TestFile, Failure> {
        note_seed(self.seed);
        let mut overrides = self.overrides.clone();
        overrides.push(assignment.to_owned());
        TestFile::load_any(&self.test, &overrides)
    }

    /// Another test file, with the same overrides.
    fn load_other(&self, file: &Path) -> Result<TestFile, Failure> {
        TestFile::load(file, &self.overrides)
    }

    /// The test file and others.
    fn files(&self, more: &[PathBuf]) -> Vec<PathBuf> {
        std::iter::once(&self.test).chain(more).cloned().collect()
    }

    /// The test on a ground motion, see [`MotionArguments::shaking`].
    fn experiment(&self, test: &TestFile, named: Option<&Path>) -> Result<Experiment, Failure> {
        let shaking = self.motion.shaking(named, &test.excitation)?;
        Experiment::new(test.clone(), &shaking, self.duration)
    }
}

/// Each named ground motion, or the test's own.
fn each_record(named: &[PathBuf]) -> Vec<Option<&Path>> {
    match named {
        [] => vec![None],
        files => files.iter().map(|f| Some(f.as_path())).collect(),
    }
}

/// Reads the name of a compensation and lists the names for the shell. A force law and a predictor may be joined, so the
/// name is looked up by [`experiment::method`] and not here.
#[derive(Clone, Copy, Debug)]
pub struct MethodName;

impl TypedValueParser for MethodName {
    type Value = String;

    fn parse_ref(
        &self,
        command: &clap::Command,
        argument: Option<&clap::Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        StringValueParser::new().parse_ref(command, argument, value)
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let names = Method::ALL.iter().map(|method| method.name());
        Some(Box::new(names.map(PossibleValue::new)))
    }
}

/// Hands over the result of a verb. With `--out` the document's page and figures and further `files` are written to a
/// folder. Then with `--json` the figures are printed alone, else the answer and the location of the page. `document` is
/// told whether there is a page.
fn hand_over<N: Into<String>, T: Into<Vec<u8>>>(
    (out, json): (Option<&Path>, bool),
    files: impl FnOnce() -> Result<Vec<(N, T)>, Failure>,
    document: impl FnOnce(bool) -> Result<Document, Failure>,
) -> Result<(), Failure> {
    let document = document(out.is_some())?;
    if let Some(folder) = out {
        let own = document.files().into_iter();
        let own = own.map(|(name, file)| (name.to_owned(), file));
        let files = files()?
            .into_iter()
            .map(|(name, file)| (name.into(), file.into()));
        output::write_all(
            folder,
            &files.chain(own).collect::<Vec<(String, Vec<u8>)>>(),
        )?;
    }
    if json {
        answer!("{}", document.json());
    } else {
        println!("{}", document.terminal());
        look_at_page(out);
    }
    Ok(())
}

/// The same for several tests; if not all of them ran, the page begins with how many did.
fn hand_over_tests<N: Into<String>, T: Into<Vec<u8>>>(
    (done, asked): (usize, usize),
    wanted: (Option<&Path>, bool),
    files: impl FnOnce() -> Result<Vec<(N, T)>, Failure>,
    document: impl FnOnce(bool) -> Result<Document, Failure>,
) -> Result<(), Failure> {
    hand_over(wanted, files, |page| {
        let mut document = document(page)?;
        if done != asked {
            document.warn_first(format!(
                "**Interrupted**: {done} of {asked} tests ran, and only they are reported."
            ));
        }
        Ok(document)
    })
}

/// For a verb without files besides the page and its JSON.
fn no_files() -> Result<Vec<(&'static str, String)>, Failure> {
    Ok(Vec::new())
}

/// Prints the location of the page, if one was written.
fn look_at_page(folder: Option<&Path>) {
    if let Some(folder) = folder {
        println!("Look at {}", folder.join("report.html").display());
    }
}

/// Checks that all tests ran; after Ctrl-C only some have.
fn require_all_ran(done: usize, asked: usize) -> Result<(), Failure> {
    if done == asked {
        return Ok(());
    }
    Err(Failure::test(format!(
        "interrupted: {done} of {asked} tests ran, and only they are reported"
    )))
}
