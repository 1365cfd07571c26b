//! `outerloop check`: whether a test may be run.

use super::{MethodName, MotionArguments, coupled, hand_over, no_files};
use crate::answer::{CheckSection, TestSection, of_check};
use crate::document::Document;
use crate::provenance::{WithProvenance, note_seed};
use crate::terminal::Progress;
use experiment::Experiment;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::files::test::TestFile;
use experiment::soundness::{self, Judgement, SoundnessVerdict};
use experiment::stability::perturbed::Spread;
use experiment::stability::small_motion::Learning;
use experiment::stability::{self, Stability};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Check whether a test may be run: exit status 0 stable, 1 doubtful, 2 unstable
///
/// Bad input has exit status 2, too, but writes nothing on standard output and one sentence on standard error.
#[derive(clap::Args, Debug)]
pub struct Check {
    /// The test file
    test: PathBuf,
    /// The ground motion: CSV, AT2, or one acceleration a line
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    #[command(flatten)]
    motion: MotionArguments,
    /// Override a value of the test file, e.g. plant.actuator.delay_ms=8
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// The compensation, instead of the test file's
    #[arg(long, value_name = "NAME", value_parser = MethodName, hide_possible_values = true)]
    compensation: Option<String>,
    /// Number of perturbed rigs
    #[arg(long, default_value_t = 200)]
    plants: usize,
    /// Seed of their draw and of the noise of the planned motion
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Standard deviation of the actuator's times, per cent; of two coupled ones only if [coupled.spread] has 0 for all times
    #[arg(long, default_value_t = 10.0, value_name = "PERCENT")]
    delay_spread: f64,
    /// Standard deviation of the actuator's gain, per cent; of two coupled ones only if coupled.spread.gain_ratio is 0
    #[arg(long, default_value_t = 2.0, value_name = "PERCENT")]
    gain_spread: f64,
    /// Standard deviation of the specimen's stiffness, per cent
    #[arg(long, default_value_t = 5.0, value_name = "PERCENT")]
    stiffness_spread: f64,
    /// Standard deviation of the structure's damping, per cent; with two coupled actuators of the specimen's
    #[arg(long, default_value_t = 20.0, value_name = "PERCENT")]
    damping_spread: f64,
    /// Write report.html and check.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Check {
    /// Checks the test.
    ///
    /// # Errors
    /// Bad input; a test that is doubtful or unstable.
    pub fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(self.out.as_deref(), &["report.html", "check.json"])?;
        let wanted = (out.as_deref(), self.json);
        let spread = self.spread()?;
        note_seed(self.seed);
        let experiment = self.experiment()?;
        let Judgement {
            verdict, reason, ..
        } = match experiment.test.coupled {
            Some(_) => coupled::check(&experiment, &spread, wanted)?,
            None => check(&experiment, &spread, wanted)?,
        };
        verdict.outcome(format!(
            "{}: {}: {reason}",
            self.test.display(),
            verdict.name()
        ))
    }

    /// The planned motion.
    fn experiment(&self) -> Result<Experiment, Failure> {
        let test = TestFile::load_any(&self.test, &self.overrides)?;
        let compensation = match &self.compensation {
            Some(name) => test.compensation_named(name)?,
            None => test.compensation(),
        };
        let shaking = self
            .motion
            .shaking(self.record.as_deref(), &test.excitation)?;
        Experiment::new(test, &shaking, None)?.under(compensation)
    }

    fn spread(&self) -> Result<Spread, Failure> {
        if !(1..=100_000).contains(&self.plants) {
            return Err(Failure::input(format!(
                "--plants {}: accepted are 1 to 100000",
                self.plants
            )));
        }
        let share = |name: &str, percent: f64| {
            (0.0..=100.0)
                .contains(&percent)
                .then_some(percent / 100.0)
                .ok_or_else(|| {
                    Failure::input(format!(
                        "--{name} {percent}: accepted are 0 to 100 per cent"
                    ))
                })
        };
        Ok(Spread {
            plants: self.plants,
            seed: self.seed,
            delay: share("delay-spread", self.delay_spread)?,
            gain: share("gain-spread", self.gain_spread)?,
            stiffness: share("stiffness-spread", self.stiffness_spread)?,
            damping: share("damping-spread", self.damping_spread)?,
        })
    }
}

/// Checks a test whose actuators each move a floor of their own.
fn check(
    experiment: &Experiment,
    spread: &Spread,
    wanted: (Option<&Path>, bool),
) -> Result<Judgement, Failure> {
    let (judgement, answer) = judge(experiment, spread)?;
    let whole = CheckAnswer {
        judgement: &judgement,
        answer: &answer,
    };
    hand_over(wanted, no_files, |page| {
        document(experiment, &whole, page)?.with_figures("check.json", &WithProvenance::of(&whole))
    })?;
    Ok(judgement)
}

/// The verdict, with better alternatives, and what small motions say.
fn judge(experiment: &Experiment, spread: &Spread) -> Result<(Judgement, Stability), Failure> {
    let test = &experiment.test;
    let mut judgement = {
        let progress = Progress::over("tests", 3);
        soundness::judge(experiment, spread, || progress.add(1))?
    };
    let unstable = judgement.verdict == SoundnessVerdict::Unstable;
    let answer = {
        let question = experiment.small_motions(Learning::On)?;
        let progress = Progress::over("rigs", spread.plants as u64);
        stability::answer(&question, spread, unstable, || progress.add(1))?
    };
    let not_stable = judgement.verdict != SoundnessVerdict::Stable;
    let by_small_motions = not_stable && soundness::fixed(test);
    if let Some(reason) = answer.reason.as_ref().filter(|_| by_small_motions) {
        judgement.reason = reason.clone();
    }
    judgement.add_alternatives(experiment)?;
    Ok((judgement, answer))
}

/// The result; for a page the planned motion runs again, with every step kept.
fn document(
    experiment: &Experiment,
    whole: &CheckAnswer<'_>,
    with_page: bool,
) -> Result<Document, Failure> {
    let mut section = CheckSection {
        experiment,
        judgement: whole.judgement,
        answer: whole.answer,
        drawn: None,
    };
    if !with_page {
        return Ok(of_check(&section));
    }
    let ideal = experiment.ideal()?;
    let method = experiment.test.config.compensation.kind;
    let seed = whole.answer.perturbed.spread.seed;
    let run = experiment.run(method, &ideal, seed, true, ())?;
    let small_motions = experiment.small_motions(Learning::On)?;
    let over_delay = stability::limits::over_delay(&small_motions, &whole.answer.limits)?;
    let kept = || Failure::test("the planned motion kept no record");
    let planned = TestSection {
        experiment,
        summary: &run.summary,
        trace: run.trace.as_ref().ok_or_else(kept)?,
        ideal: &ideal,
    };
    section.drawn = Some((&over_delay, planned));
    Ok(of_check(&section))
}

/// The answer of `check --json`.
#[derive(Serialize, JsonSchema)]
pub(crate) struct CheckAnswer<'a> {
    #[serde(flatten)]
    judgement: &'a Judgement,
    #[serde(flatten)]
    answer: &'a Stability,
}
