//! `outerloop sweep`: the same test over the values of one key, or on rigs drawn around the declared one; the latter is
//! also `outerloop monte-carlo`.

use super::{CommonArguments, MethodName, each_record, hand_over_tests, require_all_ran};
use crate::answer::{self, TestSection};
use crate::many::{self, OneOfMany, Outcome, Range};
use crate::provenance::WithProvenance;
use crate::terminal::{Progress, interrupt};
use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::drawn::DrawnRigs;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::stability::perturbed::Spread;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt::Write as _;
use std::path::PathBuf;
use std::time::Instant;

/// Run the same test over the values of one key, or on drawn rigs
#[derive(clap::Args, Debug)]
pub struct Sweep {
    #[command(flatten)]
    common: CommonArguments,
    /// The key and its values, e.g. plant.actuator.delay_ms=0..20/11 (eleven of them) or excitation.scale=0.5,1,2
    #[arg(long, value_name = "PATH=VALUES", required_unless_present = "drawn")]
    over: Option<String>,
    /// Number of rigs drawn around the declared one, on one ground motion under one compensation; standard deviations: times of
    /// the actuator 10 %, its gain 2 %, stiffness of the specimen 5 %; with two coupled actuators its damping 20 %, and times and
    /// gains by [coupled.spread] where that is above 0
    #[arg(
        long,
        value_name = "RIGS",
        conflicts_with = "over",
        allow_negative_numbers = true
    )]
    drawn: Option<usize>,
    /// A ground motion; may be given several times
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,
    /// Compensations, separated by commas; left out: the test file's
    #[arg(long, value_delimiter = ',', value_name = "A,B,...", value_parser = MethodName, hide_possible_values = true)]
    compensations: Vec<String>,
    /// Write report.html, sweep.csv and sweep.json there; with --drawn tests.csv (each rig, and how its test ended) and
    /// monte-carlo.json
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Run the same test on many rigs drawn around the declared one: sweep --drawn
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
    /// Number of drawn rigs, with one test each
    #[arg(long, default_value_t = 10_000)]
    tests: usize,
    /// Write report.html, tests.csv (each rig, and how its test ended) and monte-carlo.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl MonteCarlo {
    /// Runs all tests.
    ///
    /// # Errors
    /// Bad input.
    pub fn run(self) -> Result<(), Failure> {
        let sweep = Sweep {
            common: self.common,
            over: None,
            drawn: None,
            record: self.record.into_iter().collect(),
            compensations: self.compensation.into_iter().collect(),
            out: self.out,
        };
        sweep.on_drawn("--tests", self.tests)
    }
}

/// Standard deviations of the rigs, as `check` has them where nothing else is asked for.
const SPREAD: Spread = Spread {
    plants: 0,
    seed: 0,
    delay: 0.10,
    gain: 0.02,
    stiffness: 0.05,
    damping: 0.20,
};

/// Tests whose ideal responses are computed together.
const TOGETHER: usize = 4;

/// The key that `--duration` overrides.
const DURATION: &str = "excitation.duration_s";

/// The result of a sweep.
#[derive(Serialize, JsonSchema)]
pub(crate) struct SweepResult<'a> {
    /// Path of the key.
    path: &'a str,
    /// Each test.
    rows: &'a [OneOfMany],
}

impl Sweep {
    /// Runs all tests, on all cores.
    ///
    /// # Errors
    /// Bad input; Ctrl-C before all tests have run.
    pub fn run(&self) -> Result<(), Failure> {
        match (&self.over, self.drawn) {
            (Some(over), _) => self.over_values(over),
            (None, drawn) => self.on_drawn("--drawn", drawn.unwrap_or_default()),
        }
    }

    fn over_values(&self, over: &str) -> Result<(), Failure> {
        let names = ["report.html", "sweep.csv", "sweep.json"];
        let out = look_ahead::folder(self.out.as_deref(), &names)?;
        interrupt::watch();
        let range = Range::parse(over)?;
        if range.path == DURATION && self.common.duration.is_some() {
            return Err(Failure::input(format!(
                "--over {DURATION} and --duration exclude each other: accepted is one"
            )));
        }
        let experiments = self.experiments(&range)?;
        let Some((_, first)) = experiments.first() else {
            return require_all_ran(0, range.values.len());
        };
        let own = vec![first.test.compensation()];
        let methods = first.test.compensations(&self.compensations, own)?;
        let steps: usize = experiments.iter().map(|(_, e)| e.control_steps()).sum();
        let rows = {
            let progress = Progress::over("sweep", (steps * methods.len()) as u64);
            let lay_out = |i: usize| Ok(vec![experiments[i].clone()]);
            let seed = |_| self.common.seed;
            many::run(experiments.len(), lay_out, &methods, seed, &progress)?
        };
        let path = &range.path;
        let swept = SweepResult { path, rows: &rows };
        let names: Vec<&'static str> = methods.iter().map(|m| m.name()).collect();
        let asked = range.values.len() * each_record(&self.record).len() * methods.len();
        hand_over_tests(
            (rows.len(), asked),
            (out.as_deref(), self.common.json),
            || Ok(vec![("sweep.csv", values_csv(&rows))]),
            |page| {
                answer::of_values(path, &rows, &names, first, page).with_figures(
                    "sweep.json",
                    &WithProvenance::seeded(&swept, self.common.seed),
                )
            },
        )?;
        require_all_ran(rows.len(), asked)
    }

    /// Each value with each ground motion.
    fn experiments(&self, range: &Range) -> Result<Vec<(f64, Experiment)>, Failure> {
        let mut all = Vec::new();
        for value in &range.values {
            if interrupt::asked() {
                break;
            }
            let test = self.common.load_with(&range.setting(*value))?;
            for file in each_record(&self.record) {
                all.push((*value, self.common.experiment(&test, file)?));
            }
        }
        Ok(all)
    }

    /// The test that runs on drawn rigs, asked for by the option `option`, and its compensation.
    fn one(&self, option: &str) -> Result<(Experiment, Compensation), Failure> {
        let test = self.common.load_any()?;
        let (record, kind) = match (&self.record[..], &self.compensations[..]) {
            ([] | [_], []) => (self.record.first(), test.compensation()),
            ([] | [_], [name]) => (self.record.first(), test.compensation_named(name)?),
            _ => {
                return Err(Failure::input(format!(
                    "{option}: accepted are one ground motion and one compensation"
                )));
            }
        };
        let record = record.map(PathBuf::as_path);
        Ok((self.common.experiment(&test, record)?, kind))
    }

    /// The same test on `tests` drawn rigs.
    fn on_drawn(&self, option: &str, tests: usize) -> Result<(), Failure> {
        let names = ["report.html", "tests.csv", "monte-carlo.json"];
        let out = look_ahead::folder(self.out.as_deref(), &names)?;
        if !(1..=1_000_000).contains(&tests) {
            return Err(Failure::input(format!(
                "{option} {tests}: accepted are 1 to 1000000"
            )));
        }
        let (experiment, kind) = self.one(option)?;
        let spread = Spread {
            plants: tests,
            seed: self.common.seed,
            ..SPREAD
        };
        let rigs = DrawnRigs::around(&experiment, &spread);
        interrupt::watch();
        let began = Instant::now();
        // What is wrong with a specimen is no error of the test: each has its own ideal.
        let on_rig = |i: usize| -> Result<_, Failure> { Ok((i as f64, rigs.test(i)?)) };
        let seed = |number: f64| self.common.seed.wrapping_add(number as u64);
        let rows = {
            let progress = Progress::over("tests", (experiment.control_steps() * tests) as u64);
            let lay_out = |group: usize| {
                let first = group * TOGETHER;
                (first..(first + TOGETHER).min(tests)).map(on_rig).collect()
            };
            many::run(tests.div_ceil(TOGETHER), lay_out, &[kind], seed, &progress)?
        };
        if rows.is_empty() {
            return require_all_ran(0, tests);
        }
        let outcome = outcome(&rows, kind.name(), began.elapsed().as_secs_f64());
        let factors = rows.iter().map(|r| rigs.factors(r.value as usize));
        let factors: Vec<Vec<f64>> = factors.collect();
        let drawn = answer::Drawn {
            outcome: &outcome,
            quantities: rigs.quantities(),
            rows: &rows,
            factors: &factors,
        };
        let page = |with_page: bool| {
            if !with_page {
                return Ok(answer::of_rigs(&drawn, None));
            }
            // The worst test once more, with every step kept.
            let error = |i: &usize| rows[*i].summary.error();
            let worst = (0..rows.len()).max_by(|a, b| error(a).total_cmp(&error(b)));
            let worst = worst.unwrap_or(0);
            let own = rigs.test(rows[worst].value as usize)?;
            let ideal = own.ideal()?;
            let run = own.run(kind, &ideal, seed(rows[worst].value), true, ())?;
            let kept = || Failure::test("the worst test kept no record");
            let section = TestSection {
                experiment: &own,
                summary: &run.summary,
                trace: run.trace.as_ref().ok_or_else(kept)?,
                ideal: &ideal,
            };
            Ok(answer::of_rigs(&drawn, Some((&factors[worst], section))))
        };
        hand_over_tests(
            (rows.len(), tests),
            (out.as_deref(), self.common.json),
            || Ok(vec![("tests.csv", rigs_csv(&drawn))]),
            |with_page| {
                page(with_page)?.with_figures(
                    "monte-carlo.json",
                    &WithProvenance::seeded(&outcome, self.common.seed),
                )
            },
        )?;
        require_all_ran(rows.len(), tests)
    }
}

fn values_csv(rows: &[OneOfMany]) -> String {
    let mut text = String::from(
        "value,ground_motion,compensation,verdict,eps_rms_1,eps_max_1,peak_displacement_m,ideal_peak_m\n",
    );
    for r in rows {
        let s = &r.summary;
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{}",
            r.value,
            s.record.replace(',', ";"),
            s.compensation,
            s.verdict.name(),
            s.eps_rms,
            s.eps_max,
            s.peak_displacement_m,
            r.ideal_peak_m
        );
    }
    text
}

fn rigs_csv(drawn: &answer::Drawn<'_>) -> String {
    let columns = drawn.quantities.iter().map(|q| format!("{},", q.column));
    let columns: String = columns.collect();
    let mut text = format!("test,{columns}verdict,eps_rms_1,eps_max_1\n");
    for (r, factors) in drawn.rows.iter().zip(drawn.factors) {
        let s = &r.summary;
        let factors: String = factors.iter().map(|f| format!("{f},")).collect();
        let _ = writeln!(
            text,
            "{},{factors}{},{},{}",
            r.value,
            s.verdict.name(),
            s.eps_rms,
            s.eps_max
        );
    }
    text
}

fn outcome(rows: &[OneOfMany], compensation: &'static str, wall_s: f64) -> Outcome {
    let mut errors: Vec<f64> = rows.iter().map(|r| r.summary.error()).collect();
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[((errors.len() - 1) as f64 * share).round() as usize];
    let steps: usize = rows.iter().map(|r| r.summary.steps).sum();
    Outcome {
        compensation,
        tests: rows.len(),
        threads: rayon::current_num_threads(),
        wall_s,
        tests_per_s: rows.len() as f64 / wall_s,
        control_steps_per_s: steps as f64 / wall_s,
        completed: errors.iter().filter(|e| e.is_finite()).count(),
        eps_rms_median: at(0.5),
        eps_rms_95: at(0.95),
        eps_rms_worst: at(1.0),
    }
}
