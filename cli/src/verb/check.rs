//! `outerloop check`: whether a test may be run, before the oil is on.

mod surveys;

use super::coupled::CoupledCheckRequest;
use super::{MotionArguments, hand_over, json, method};
use crate::provenance::{WithProvenance, note_seed};
use crate::report::{self, CheckSection, TestSection};
use crate::terminal::{Progress, table};
use experiment::Experiment;
use experiment::coupled::load;
use experiment::failure::Failure;
use experiment::files::output;
use experiment::files::test::TestFile;
use experiment::numbers::{percent, percent_or_lost};
use experiment::soundness::{self, Eigenvalues, Judgement, SoundnessVerdict};
use experiment::stability::linear_verdict::LinearVerdict;
use experiment::stability::perturbed::Spread;
use experiment::stability::{self, Stability};
use experiment::summary::GOOD_EPS_RMS;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Check whether a test may be run, before the oil is on: exit status 0 stable, 1 doubtful, 2 unstable
#[derive(clap::Args, Debug)]
pub struct Check {
    /// The test file
    #[arg(required_unless_present_any = ["survey", "monitor"])]
    test: Option<PathBuf>,
    /// The ground motion: CSV, AT2, or one acceleration a line
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    #[command(flatten)]
    motion: MotionArguments,
    /// Instead of a test: compare the verdicts with what the tests then do, over this many drawn rigs
    #[arg(long, value_name = "RIGS", num_args = 0..=1, default_missing_value = "1000", conflicts_with = "test")]
    survey: Option<usize>,
    /// Instead of a test: try the energy monitor on this many sound tests, and on a quarter as many in which something
    /// breaks
    #[arg(
        long,
        value_name = "TESTS",
        num_args = 0..=1,
        default_missing_value = "10000",
        conflicts_with_all = ["test", "survey"]
    )]
    monitor: Option<usize>,
    /// Override a value of the test file, e.g. plant.actuator.delay_ms=8
    #[arg(long = "set", value_name = "PATH=VALUE")]
    overrides: Vec<String>,
    /// The compensation, instead of the test file's
    #[arg(long, value_name = "NAME")]
    compensation: Option<String>,
    /// How many perturbed rigs
    #[arg(long, default_value_t = 200)]
    plants: usize,
    /// Seed of their draw
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Standard deviation of the actuator's times, per cent
    #[arg(long, default_value_t = 10.0, value_name = "PERCENT")]
    delay_spread: f64,
    /// Standard deviation of the actuator's gain, per cent
    #[arg(long, default_value_t = 2.0, value_name = "PERCENT")]
    gain_spread: f64,
    /// Standard deviation of the specimen's stiffness, per cent
    #[arg(long, default_value_t = 5.0, value_name = "PERCENT")]
    stiffness_spread: f64,
    /// Standard deviation of the structure's damping, per cent
    #[arg(long, default_value_t = 20.0, value_name = "PERCENT")]
    damping_spread: f64,
    /// Write report.html and check.json there
    #[arg(long, value_name = "DIR", conflicts_with_all = ["survey", "monitor"])]
    out: Option<PathBuf>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

impl Check {
    /// Answers.
    ///
    /// # Errors
    /// Bad input; a test that cannot be stable.
    pub fn run(&self) -> Result<(), Failure> {
        output::look_ahead(self.out.as_deref())?;
        if let Some(rigs) = self.survey {
            return self.survey(rigs);
        }
        if let Some(tests) = self.monitor {
            return self.monitor(tests);
        }
        // Clap has seen to it that there is one.
        let path = self.test.as_deref().unwrap_or(Path::new(""));
        let spread = self.spread()?;
        note_seed(self.seed);
        if let Some(test) = load::test(path, &self.overrides)? {
            let asked = CoupledCheckRequest {
                shaking: self
                    .motion
                    .shaking(self.record.as_deref(), &test.excitation)?,
                compensation: self.compensation.as_deref(),
                spread,
                out: self.out.as_deref(),
                json: self.json,
            };
            return super::coupled::check(&test, &asked);
        }
        let mut test = TestFile::load(path, &self.overrides)?;
        if let Some(name) = &self.compensation {
            test.config.compensation.kind = method(name)?;
        }
        let answer = {
            let progress = Progress::over("rigs", spread.plants as u64);
            stability::answer(&test, &spread, || progress.add(1))?
        };
        let experiment = self.experiment(&test)?;
        let judgement = judge(&experiment, &spread, &answer)?;
        let whole = Whole {
            judgement: &judgement,
            answer: &answer,
        };
        let tell = || {
            print(&answer);
            // Why a test is not stable is said once, at the end.
            let why = match judgement.verdict {
                SoundnessVerdict::Stable => format!(": {}", judgement.reason),
                _ => String::new(),
            };
            println!(
                "\n{}{why}.\nExpected error: {}.",
                judgement.verdict.name().to_uppercase(),
                expected(&judgement),
            );
        };
        hand_over(
            (self.out.as_deref(), self.json),
            ("check.json", &json(&WithProvenance::of(&whole))?),
            || Ok(vec![("report.html", page(&experiment, &whole)?)]),
            tell,
        )?;
        let said = format!("{}: {}", path.display(), judgement.reason);
        judgement.verdict.outcome(said)
    }

    /// The planned motion.
    fn experiment(&self, test: &TestFile) -> Result<Experiment, Failure> {
        let shaking = self
            .motion
            .shaking(self.record.as_deref(), &test.excitation)?;
        Experiment::new(test.clone(), &shaking, None)
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

/// The verdict, and what would be better.
fn judge(
    experiment: &Experiment,
    spread: &Spread,
    answer: &Stability,
) -> Result<Judgement, Failure> {
    let test = &experiment.test;
    let eigenvalues = Eigenvalues::of(test)?;
    let progress = Progress::over("tests", 3);
    let mut judgement = soundness::judge(experiment, &eigenvalues, spread, || progress.add(1))?;
    if judgement.verdict == SoundnessVerdict::Stable {
        return Ok(judgement);
    }
    if let Some(reason) = answer.reason.as_ref().filter(|_| soundness::fixed(test)) {
        judgement.reason = reason.clone();
    }
    let others: Vec<String> = soundness::alternatives(experiment, GOOD_EPS_RMS)?
        .into_iter()
        .take(3)
        .map(|(name, eps)| format!("{name} ({})", percent(eps)))
        .collect();
    if !others.is_empty() {
        judgement.reason += &format!(
            "; the planned motion is good with the compensations {}",
            others.join(", ")
        );
    }
    Ok(judgement)
}

/// The error to expect, in words.
fn expected(judgement: &Judgement) -> String {
    if !judgement.expected_eps_rms.is_finite() {
        return "none, since the planned motion does not run to its end".into();
    }
    format!(
        "{} rms; {} on a rig that differs",
        percent(judgement.expected_eps_rms),
        percent_or_lost(judgement.expected_eps_rms_differing)
    )
}

/// The report.
fn page(experiment: &Experiment, whole: &Whole<'_>) -> Result<String, Failure> {
    let ideal = experiment.ideal()?;
    let method = experiment.test.config.compensation.kind;
    let seed = whole.answer.perturbed.spread.seed;
    let run = experiment.run(method, &ideal, seed, true, ())?;
    Ok(report::of_check(&CheckSection {
        judgement: whole.judgement,
        answer: whole.answer,
        over_delay: &stability::limits::over_delay(&experiment.test, &whole.answer.limits)?,
        planned: TestSection {
            experiment,
            summary: &run.summary,
            trace: run
                .trace
                .as_ref()
                .ok_or_else(|| Failure::test("the planned motion kept no record"))?,
            ideal: &ideal,
        },
    }))
}

/// All that is found out, as JSON.
#[derive(Serialize)]
struct Whole<'a> {
    #[serde(flatten)]
    judgement: &'a Judgement,
    #[serde(flatten)]
    answer: &'a Stability,
}

fn or_none(value: Option<f64>, text: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| "none found".into(), text)
}

fn print(a: &Stability) {
    println!(
        "{} states over an integration step of {:.4} ms.\n",
        a.states,
        a.step_s * 1e3
    );
    let mut t = table(&[
        "compensation",
        "stable",
        "largest |z|",
        "growth a second",
        "damping, mode 1",
    ]);
    let mut row = |r: &LinearVerdict, here: &str| {
        t.add_row([
            format!("{}{here}", r.compensation),
            if r.stable { "yes" } else { "no" }.to_owned(),
            format!("{:.7}", r.spectral_radius),
            percent(r.growth_per_s.exp_m1()),
            if r.damping_ratio.is_nan() {
                "-".into()
            } else {
                percent(r.damping_ratio)
            },
        ]);
    };
    row(&a.row, "  <- this test");
    if let Some(start) = &a.at_start {
        row(start, ", before it has learnt");
    }
    for r in &a.alternatives {
        row(r, "");
    }
    println!("{t}\n");

    let mut t = table(&["mode", "structure", "in the loop", "damping in the loop"]);
    for (i, m) in a.modes.iter().enumerate() {
        t.add_row([
            format!("{}", i + 1),
            format!("{:.3} Hz", m.structure_hz),
            format!("{:.3} Hz", m.frequency_hz),
            percent(m.damping_ratio),
        ]);
    }
    println!("{t}\n");

    let mut t = table(&["", "present", "limit", "margin"]);
    let margin = |l: &stability::limits::StabilityLimit| {
        l.margin_percent
            .map_or_else(|| "-".into(), |m| format!("{m:.1} %"))
    };
    let (delay, gain) = (&a.limits.delay, &a.limits.gain);
    t.add_row([
        "delay".into(),
        format!("{:.3} ms", delay.present),
        or_none(delay.limit, |x| format!("{x:.3} ms")),
        margin(delay),
    ]);
    t.add_row([
        "loop gain".into(),
        format!("{:.3}", gain.present),
        or_none(gain.limit, |x| format!("{x:.3}")),
        margin(gain),
    ]);
    let needed = a.limits.time_scale_needed;
    t.add_row([
        "time scale".into(),
        format!("{:.3}", a.time_scale),
        or_none(needed, |x| format!("at least {x:.3}")),
        needed.map_or_else(
            || "-".into(),
            |x| format!("{:.1} %", (a.time_scale / x - 1.0) * 100.0),
        ),
    ]);
    println!("{t}\n");

    let mut t = table(&["delay budget", "ms", "from"]);
    for p in &a.delay_budget {
        t.add_row([
            p.part.to_owned(),
            format!("{:+.3}", p.ms),
            p.from.to_owned(),
        ]);
    }
    println!("{t}\n");

    let p = &a.perturbed;
    println!(
        "{} of {} perturbed rigs are unstable (standard deviations: times {}, gain {}, stiffness {}, damping {}).\n\
         Worst: {} a second, least damping of mode 1 {}.",
        p.unstable,
        p.spread.plants,
        percent(p.spread.delay),
        percent(p.spread.gain),
        percent(p.spread.stiffness),
        percent(p.spread.damping),
        percent(p.worst_growth_per_s.exp_m1()),
        percent(p.least_damping_ratio),
    );
    for note in &a.notes {
        println!("Note: {note}.");
    }
}
