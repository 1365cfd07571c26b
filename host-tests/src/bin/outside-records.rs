//! The table of all open third-party records: verdict, names, error before and after, textbook fit, noise floor, points.
//!
//! ```text
//! cargo run --release -p host-tests --bin outside-records -- [--folder DIR] [CASE]...
//! ```

use clap::Parser;
use comfy_table::{Table, presets};
use diagnosis::ChannelAnswer;
use exam::aims::{self, Aim, Figure};
use host_tests::outside::{Case, cases_in, lot};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let cases = match &arguments.folder {
        Some(folder) => cases_in(folder),
        None => Ok(["outside", "outside2"]
            .into_iter()
            .filter_map(lot)
            .flatten()
            .collect()),
    };
    let cases: Vec<Case> = match cases {
        Ok(cases) => cases,
        Err(why) => {
            eprintln!("outside-records: {why}");
            return ExitCode::from(2);
        }
    };
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN).set_header([
        "record",
        "verdict",
        "names (q) or set (probability)",
        "before",
        "after",
        "textbook",
        "floor",
        "points",
        "s",
    ]);
    let only = &arguments.cases;
    let mut kinds: BTreeMap<String, Kind> = BTreeMap::new();
    let mut seconds = Vec::new();
    for case in cases
        .iter()
        .filter(|c| only.is_empty() || only.contains(&c.id))
    {
        eprintln!("{}", case.id);
        let (row, got) = row(case);
        table.add_row(row);
        // The generator of a lot puts each record's kind in front of its id.
        let kind = match &arguments.folder {
            Some(_) => case.id.split('_').next().unwrap_or_default(),
            None => "all",
        };
        kinds.entry(kind.to_owned()).or_default().add(&got);
        seconds.extend(got.seconds);
    }
    println!("{table}");
    for (kind, k) in &kinds {
        let both = match k.pairs {
            0 => String::new(),
            n => format!(", both causes named in {} of {n}", k.both),
        };
        println!(
            "{kind}: {} of {} points, {} wrong{both}",
            k.points, k.records, k.wrong
        );
    }
    println!("\n{}", aimed(&kinds, &aims::seconds(seconds)));
    if arguments.folder.is_some() && kinds.is_empty() {
        eprintln!("outside-records: the folder's cases.toml has no such case");
        return ExitCode::FAILURE;
    }
    let lost: Vec<String> = BOUNDS.iter().filter_map(|b| b.lost(&kinds)).collect();
    if only.is_empty() && !lost.is_empty() {
        eprintln!("outside-records: {}", lost.join("; "));
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}

/// What no change may lose, of a kind of records.
struct Bound {
    kind: &'static str,
    /// Least points a record.
    points: f64,
    /// Largest fraction of wrong names.
    wrong: f64,
}

/// Of the open third-party records, and of each kind of OpenSees' laws on any seed.
const BOUNDS: [Bound; 5] = [
    bound("all", 0.78, 0.0),
    bound("clean", 1.0, 0.0),
    bound("one", 0.6, 0.1),
    bound("two", 0.5, 0.15),
    bound("outside", 0.3, 0.3),
];

const fn bound(kind: &'static str, points: f64, wrong: f64) -> Bound {
    Bound {
        kind,
        points,
        wrong,
    }
}

impl Bound {
    /// The sentence on a bound that does not hold.
    fn lost(&self, kinds: &BTreeMap<String, Kind>) -> Option<String> {
        let k = kinds.get(self.kind)?;
        let all = k.records as f64;
        let holds = k.points >= self.points * all && k.wrong as f64 <= self.wrong * all;
        let Self {
            kind,
            points,
            wrong,
        } = self;
        (!holds).then(|| {
            format!(
                "of {} records of the kind {kind}, {} points and {} wrong: expected at least {points} points and at most {wrong} \
                 wrong a record",
                k.records, k.points, k.wrong
            )
        })
    }
}

/// By how much the aims for published records, or for OpenSees' laws, and for the time are missed.
fn aimed(kinds: &BTreeMap<String, Kind>, seconds: &[Figure]) -> String {
    let of = |kind: &str| kinds.get(kind).copied().unwrap_or_default();
    let points = |k: Kind| Figure::share(k.points, k.records);
    let seconds: (&[Aim], &[Figure]) = (&aims::SECONDS, seconds);
    if let Some(all) = kinds.get("all") {
        let wrong = Figure::share(all.wrong as f64, all.records);
        let league = [points(*all), wrong, points(*all), wrong];
        return aims::table(&[(&aims::LEAGUES, &league), seconds]);
    }
    let both = Figure::share(of("two").both as f64, of("two").pairs);
    let laws = [
        points(of("one")),
        both,
        points(of("outside")),
        points(of("clean")),
    ];
    aims::table(&[(&aims::OPENSEES, &laws), seconds])
}

/// Diagnose records with known causes
#[derive(Parser, Debug)]
struct Arguments {
    /// Only these cases; left out: all
    cases: Vec<String>,
    /// A folder with a cases.toml; left out: the open third-party records
    #[arg(long)]
    folder: Option<PathBuf>,
}

/// The result for a record.
#[derive(Clone, Copy, Debug, Default)]
struct Got {
    points: f64,
    wrong: bool,
    both: Option<bool>,
    /// How long it took, s; `None` for a refused record.
    seconds: Option<f64>,
}

/// The results for the records of a kind.
#[derive(Clone, Copy, Debug, Default)]
struct Kind {
    points: f64,
    records: usize,
    wrong: usize,
    both: usize,
    pairs: usize,
}

impl Kind {
    fn add(&mut self, got: &Got) {
        self.points += got.points;
        self.records += 1;
        self.wrong += usize::from(got.wrong);
        self.pairs += usize::from(got.both.is_some());
        self.both += usize::from(got.both == Some(true));
    }
}

/// What others achieve on the benchmark's multisine, simulated from its force.
const LITERATURE: &str = "a linear model 1.6e-4 m, the best black boxes 7.5e-6 m";

/// Whether the case is the benchmark for which others have published figures.
fn is_published(case: &Case) -> bool {
    case.id.starts_with("bouc_wen")
}

/// Error of the simulation with the diagnosed model, m, if that is a mass on a Bouc-Wen element.
fn simulated(case: &Case, a: &ChannelAnswer) -> Option<f64> {
    let (record, from_s) = case.held_out().ok()?;
    host_tests::simulated::displacement_error_m(a, &record, from_s)
}

fn row(case: &Case) -> (Vec<String>, Got) {
    let percent = |x: f64| format!("{:.1} %", 100.0 * x);
    match case.diagnose() {
        Err(why) => {
            let mut row = vec![case.id.clone(), "refused".into(), why];
            row.resize(9, String::new());
            (row, Got::default())
        }
        Ok((a, seconds)) => {
            for note in &a.notes {
                eprintln!("    {note}");
            }
            for e in &a.effects {
                for p in &e.parameters {
                    eprintln!(
                        "    {} {} = {:.5} [{:.5}, {:.5}] {}",
                        e.name, p.name, p.value, p.ci90[0], p.ci90[1], p.unit
                    );
                }
            }
            eprintln!("    {:?}", a.refitted);
            if let Some(error) = simulated(case, &a).filter(|_| is_published(case)) {
                println!(
                    "{}: driven by its force, the named law's displacement is off by {error:.2e} m rms; {LITERATURE}",
                    case.id
                );
            }
            let got = Got {
                points: case.points(&a),
                wrong: case.is_wrong(&a),
                both: case.has_both(&a),
                seconds: Some(seconds),
            };
            let spread = a.error_before.test_rms / a.error_before.test_nrmse.max(f64::MIN_POSITIVE);
            let row = vec![
                case.id.clone(),
                format!("{:?}", a.verdict).to_lowercase(),
                named(&a),
                percent(a.error_before.test_nrmse),
                percent(a.error_after.test_nrmse),
                percent(case.reference.after_nrmse),
                if a.noise_floor_rms > 0.0 {
                    percent(a.noise_floor_rms / spread)
                } else {
                    "?".into()
                },
                format!("{}", got.points),
                format!("{seconds:.2}"),
            ];
            (row, got)
        }
    }
}

fn named(a: &ChannelAnswer) -> String {
    let mut names: Vec<String> = Vec::new();
    if a.members.is_empty() {
        for e in &a.effects {
            let q = e.q.map_or(String::new(), |q| format!(" ({q})"));
            names.push(format!("{}{q}", e.name));
        }
        names.extend(a.alternatives.iter().map(|e| format!("or {e}")));
    }
    for m in &a.members {
        names.push(format!("{} ({:.2})", m.name, m.probability));
    }
    if let Some(n) = &a.nearest {
        names.push(format!("nearest {} ({:.2})", n.name, n.explained));
    }
    names.join(", ")
}
