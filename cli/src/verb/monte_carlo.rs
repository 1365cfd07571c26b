//! `outerloop monte-carlo`: the same test on many rigs that are not quite the declared one.

use super::{CommonArguments, MethodName, hand_over, json, require_all_ran};
use crate::provenance::WithProvenance;
use crate::report::{self, ManyTests, TestSection};
use crate::terminal::{Progress, interrupt, percent, table};
use experiment::Experiment;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::judged::JudgedRun;
use experiment::method;
use experiment::stability::perturbed::Spread;
use experiment::stability::variation::Variation;
use experiment::summary::Summary;
use experiment::trace::Response;
use outerloop_core::Method;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

/// Run the same test on many rigs drawn around the declared one
#[derive(clap::Args, Debug)]
pub struct MonteCarlo {
    #[command(flatten)]
    common: CommonArguments,
    /// The ground motion: CSV, AT2, or one acceleration a line
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// The compensation, instead of the test file's
    #[arg(long, value_name = "NAME", value_parser = MethodName, hide_possible_values = true)]
    compensation: Option<String>,
    /// How many tests
    #[arg(long, default_value_t = 10_000)]
    tests: usize,
    /// Write report.html, tests.csv (each rig, and how its test ended) and monte-carlo.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Standard deviations of the rigs, as `check` has them: times 10 %, gain 2 %, stiffness 5 %.
const SPREAD: Spread = Spread {
    plants: 0,
    seed: 0,
    delay: 0.10,
    gain: 0.02,
    stiffness: 0.05,
    damping: 0.0,
};

/// Tests whose ideals are worked out together.
const TOGETHER: usize = 4;

/// What many tests came to.
#[derive(Debug, Serialize)]
struct Outcome {
    tests: usize,
    threads: usize,
    wall_s: f64,
    tests_per_s: f64,
    control_steps_per_s: f64,
    completed: usize,
    eps_rms_median: f64,
    eps_rms_95: f64,
    eps_rms_worst: f64,
}

impl MonteCarlo {
    /// Runs all of them, on all cores.
    ///
    /// # Errors
    /// Bad input.
    pub fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(
            self.out.as_deref(),
            &["report.html", "tests.csv", "monte-carlo.json"],
        )?;
        let out = out.as_deref();
        if !(1..=1_000_000).contains(&self.tests) {
            return Err(Failure::input(format!(
                "--tests {}: accepted are 1 to 1000000",
                self.tests
            )));
        }
        let test = self.common.load()?;
        let kind = match &self.compensation {
            Some(name) => method(name)?,
            None => test.config.compensation.kind,
        };
        let experiment = self.common.experiment(&test, self.record.as_deref())?;
        let spread = Spread {
            plants: self.tests,
            seed: self.common.seed,
            ..SPREAD
        };
        let rigs = spread.draw();
        let steps = experiment.control_steps();
        let progress = Progress::over("tests", (steps * self.tests) as u64);
        let began = Instant::now();
        interrupt::watch();
        let (numbers, summaries) = self.on_all(&experiment, &rigs, kind, &progress)?;
        let rigs: Vec<_> = numbers.iter().map(|i| rigs[*i]).collect();
        if summaries.is_empty() {
            return require_all_ran(0, self.tests);
        }
        let wall_s = began.elapsed().as_secs_f64();
        drop(progress);
        let outcome = outcome(&summaries, wall_s);
        let files = || {
            // The worst once more, with every step kept.
            let worst = (0..rigs.len())
                .max_by(|a, b| summaries[*a].error().total_cmp(&summaries[*b].error()))
                .unwrap_or(0);
            let own = experiment.on_rig(&rigs[worst]);
            let ideal = own.ideal()?;
            let one = self.one_rig((own, ideal), kind, numbers[worst], None)?;
            let many = ManyTests {
                spread: &spread,
                rigs: &rigs,
                summaries: &summaries,
                worst_rig: &rigs[worst],
                worst: one.section()?,
            };
            Ok(vec![
                ("report.html", report::of_monte_carlo(&many)),
                ("tests.csv", csv(&numbers, &many)),
            ])
        };
        let text = json(&WithProvenance::seeded(&outcome, self.common.seed))?;
        hand_over(
            (out, self.common.json),
            ("monte-carlo.json", &text),
            files,
            || print(&outcome, kind.name()),
        )?;
        require_all_ran(summaries.len(), self.tests)
    }

    /// The test on all rigs, on all cores, until somebody stops it: the numbers of those that were run, and what became of
    /// them.
    fn on_all(
        &self,
        experiment: &Experiment,
        rigs: &[Variation],
        kind: Method,
        progress: &Progress,
    ) -> Result<(Vec<usize>, Vec<Summary>), Failure> {
        let parts: Vec<Vec<(usize, Summary)>> = rigs
            .par_chunks(TOGETHER)
            .enumerate()
            .filter(|_| !interrupt::asked())
            .map(|(part, rigs)| {
                let own: Vec<Experiment> = rigs.iter().map(|rig| experiment.on_rig(rig)).collect();
                let plants: Vec<_> = own.iter().map(|o| o.test.plant.clone()).collect();
                let ideals = experiment.ideals(&plants)?;
                let pairs = own.into_iter().zip(ideals).enumerate();
                pairs
                    .map(|(i, pair)| {
                        let number = part * TOGETHER + i;
                        let one = self.one_rig(pair, kind, number, Some(progress))?;
                        Ok((number, one.run.summary))
                    })
                    .collect()
            })
            .collect::<Result<_, Failure>>()?;
        Ok(parts.into_iter().flatten().unzip())
    }

    /// The test on the `i`-th rig against its own ideal: what is wrong with a specimen is no error of the test. Every step
    /// is kept where no progress is shown.
    fn one_rig(
        &self,
        (own, ideal): (Experiment, Response),
        kind: Method,
        i: usize,
        progress: Option<&Progress>,
    ) -> Result<One, Failure> {
        let seed = self.common.seed.wrapping_add(i as u64);
        let run = match progress {
            Some(progress) => own.run(kind, &ideal, seed, false, progress.observer())?,
            None => own.run(kind, &ideal, seed, true, ())?,
        };
        Ok(One { own, ideal, run })
    }
}

/// The test on one of the rigs.
struct One {
    own: Experiment,
    ideal: Response,
    run: JudgedRun,
}

impl One {
    fn section(&self) -> Result<TestSection<'_>, Failure> {
        Ok(TestSection {
            experiment: &self.own,
            summary: &self.run.summary,
            trace: self
                .run
                .trace
                .as_ref()
                .ok_or_else(|| Failure::test("the worst test kept no record"))?,
            ideal: &self.ideal,
        })
    }
}

/// Each test in a line.
fn csv(numbers: &[usize], many: &ManyTests<'_>) -> String {
    let mut tests = String::from(
        "test,actuator_times_1,actuator_gain_1,specimen_stiffness_1,verdict,eps_rms_1,eps_max_1\n",
    );
    for (i, (rig, s)) in numbers.iter().zip(many.rigs.iter().zip(many.summaries)) {
        let _ = writeln!(
            tests,
            "{i},{},{},{},{},{},{}",
            rig.delay,
            rig.gain,
            rig.stiffness,
            s.verdict.name(),
            s.eps_rms,
            s.eps_max
        );
    }
    tests
}

fn outcome(summaries: &[Summary], wall_s: f64) -> Outcome {
    let mut errors: Vec<f64> = summaries.iter().map(Summary::error).collect();
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[((errors.len() - 1) as f64 * share).round() as usize];
    let steps: usize = summaries.iter().map(|s| s.steps).sum();
    Outcome {
        tests: summaries.len(),
        threads: rayon::current_num_threads(),
        wall_s,
        tests_per_s: summaries.len() as f64 / wall_s,
        control_steps_per_s: steps as f64 / wall_s,
        completed: errors.iter().filter(|e| e.is_finite()).count(),
        eps_rms_median: at(0.5),
        eps_rms_95: at(0.95),
        eps_rms_worst: at(1.0),
    }
}

fn print(o: &Outcome, compensation: &str) {
    let mut t = table(&[
        "compensation",
        "tests",
        "completed",
        "eps_rms, median",
        "95 %",
        "worst",
    ]);
    t.add_row([
        compensation.to_owned(),
        o.tests.to_string(),
        o.completed.to_string(),
        percent(o.eps_rms_median),
        percent(o.eps_rms_95),
        percent(o.eps_rms_worst),
    ]);
    println!("{t}");
    println!(
        "{} tests on {} threads in {:.1} s: {:.0} tests and {:.2} million control steps a second.",
        o.tests,
        o.threads,
        o.wall_s,
        o.tests_per_s,
        o.control_steps_per_s * 1e-6
    );
}
