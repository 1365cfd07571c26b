//! `outerloop sweep`: the same test over the values of one key.

use super::{CommonArguments, MethodName, each_record, hand_over, json, require_all_ran};
use crate::provenance::WithProvenance;
use crate::report;
use crate::sweep::swept_test::SweptTest;
use crate::sweep::{self, Fragility, Range, SweepResult};
use crate::terminal::{interrupt, table};
use experiment::Experiment;
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use experiment::files::look_ahead;
use experiment::numbers::{length, percent_or_lost};
use std::fmt::Write as _;
use std::path::PathBuf;

/// Run the same test over the values of one key; fragility curves
#[derive(clap::Args, Debug)]
pub struct Sweep {
    #[command(flatten)]
    common: CommonArguments,
    /// The key and its values, e.g. plant.actuator.delay_ms=0..20/11 (eleven of them) or excitation.scale=0.5,1,2
    #[arg(long, value_name = "PATH=VALUES")]
    over: String,
    /// A ground motion; may be given several times
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,
    /// Compensations, separated by commas; left out: the test file's
    #[arg(long, value_delimiter = ',', value_name = "A,B,...", value_parser = MethodName, hide_possible_values = true)]
    compensations: Vec<String>,
    /// Fragility: the share of ground motions under which a floor moves further than this, mm, with a lognormal curve; for
    /// a sweep over excitation.scale
    #[arg(long, value_name = "MM", allow_negative_numbers = true)]
    limit_mm: Option<f64>,
    /// Write report.html, sweep.csv and sweep.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Sweep {
    /// Runs all of them, on all cores.
    ///
    /// # Errors
    /// Bad input; Ctrl-C before all tests ran.
    pub fn run(&self) -> Result<(), Failure> {
        let out = look_ahead::folder(
            self.out.as_deref(),
            &["report.html", "sweep.csv", "sweep.json"],
        )?;
        let out = out.as_deref();
        interrupt::watch();
        let range = Range::parse(&self.over)?;
        if let Some(mm) = self.limit_mm.filter(|mm| !(*mm > 0.0 && mm.is_finite())) {
            return Err(Failure::input(format!(
                "--limit-mm {mm}: accepted are millimetres above 0"
            )));
        }
        let experiments = self.experiments(&range)?;
        let methods = match (&self.compensations[..], experiments.first()) {
            ([], Some((_, e))) => vec![e.test.compensation()],
            (names, Some((_, e))) => {
                let named = names.iter().map(|n| e.test.compensation_named(n));
                named.collect::<Result<_, _>>()?
            }
            (_, None) => Vec::new(),
        };
        let rows = sweep::run(&experiments, &methods, self.common.seed)?;
        let curves = self.fragility(&rows, &methods);
        let swept = SweepResult {
            path: &range.path,
            rows: &rows,
            limit_mm: self.limit_mm,
            fragility: &curves,
        };
        let json_text = json(&WithProvenance::seeded(&swept, self.common.seed))?;
        let files = || {
            let page = experiments
                .first()
                .map(|(_, first)| ("report.html", report::of_sweep(&swept, first)));
            Ok(page
                .into_iter()
                .chain([("sweep.csv", csv(&rows))])
                .collect())
        };
        hand_over(
            (out, self.common.json),
            ("sweep.json", &json_text),
            files,
            || print(&swept, &methods),
        )?;
        let asked = range.values.len() * each_record(&self.record).len() * methods.len();
        require_all_ran(rows.len(), asked)
    }

    /// Each value on each ground motion.
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

    /// The curves, the ideal rig's first; none without a limit.
    fn fragility(&self, rows: &[SweptTest], methods: &[Compensation]) -> Vec<Fragility> {
        let (Some(mm), Some(first)) = (self.limit_mm, methods.first()) else {
            return Vec::new();
        };
        let limit_m = 1e-3 * mm;
        let own = |m: &Compensation| -> Vec<SweptTest> {
            let of_it = rows.iter().filter(|r| r.summary.compensation == m.name());
            of_it.cloned().collect()
        };
        let ideal = Fragility::of("ideal", &own(first), |r| r.ideal_peak_m > limit_m);
        let tested = methods
            .iter()
            .map(|m| Fragility::of(m.name(), &own(m), |r| r.beyond(limit_m)));
        std::iter::once(ideal).chain(tested).collect()
    }
}

fn print(swept: &SweepResult<'_>, methods: &[Compensation]) {
    let key = swept.path.rsplit('.').next().unwrap_or(swept.path);
    let mut head = vec![key.to_owned(), "ideal peak".into()];
    head.extend(methods.iter().map(|m| m.name().to_owned()));
    head.extend(swept.fragility.iter().map(|f| format!("beyond, {}", f.of)));
    let head: Vec<&str> = head.iter().map(String::as_str).collect();
    let mut t = table(&head);
    let mut values: Vec<f64> = swept.rows.iter().map(|r| r.value).collect();
    values.dedup();
    for value in values {
        let own = swept.rows.iter().filter(|r| r.value == value);
        let peak_m = own.map(|r| r.ideal_peak_m).fold(0.0, f64::max);
        let mut cells = vec![value.to_string(), length(peak_m)];
        cells.extend(methods.iter().map(|m| {
            sweep::worst(swept.rows, m.name(), value).map_or_else(String::new, percent_or_lost)
        }));
        cells.extend(swept.fragility.iter().map(|f| {
            let share = f.shares.iter().find(|s| s.value == value);
            share.map_or_else(String::new, |s| format!("{} of {}", s.beyond, s.of))
        }));
        t.add_row(cells);
    }
    println!("{t}");
    println!(
        "eps_rms (Eq 18) of each compensation, and the largest ideal peak; of several ground motions the worst."
    );
    if let Some(mm) = swept.limit_mm {
        println!("\nWhere a floor moves further than {}:", length(1e-3 * mm));
        for f in swept.fragility {
            println!("  {:<14}{}", f.of, f.in_words());
        }
    }
}

fn csv(rows: &[SweptTest]) -> String {
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
