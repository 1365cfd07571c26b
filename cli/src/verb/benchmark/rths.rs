//! `outerloop benchmark rths`: the benchmark problem of real-time hybrid simulation.

use super::shared::{RECORDS, check_plants, data_folder, named, refused};
use crate::failure::Failure;
use crate::files::ground_motion::{ColumnChoice, GroundMotionFile};
use crate::files::output;
use crate::files::table::NumberTable;
use crate::provenance::{WithProvenance, note_seed};
use crate::report;
use crate::terminal::{Progress, table};
use crate::verb::json;
use benchmarks::rths::case::CASES;
use benchmarks::rths::criteria::MEANING;
use benchmarks::rths::table::{SUMMARY_LEGEND, number, summary, summary_head};
use benchmarks::rths::verdict::{CAUTION, Statement, best, targets};
use benchmarks::rths::yielding::Behaviour;
use benchmarks::rths::{Bench, Contestant, RATE_HZ, Record, RthsRow, Rules, follow};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args, Debug)]
pub(super) struct Rths {
    /// Whose rules: the problem's, or those of our earlier tables
    #[arg(long, default_value = "official", value_name = "official|own")]
    rules: String,
    /// Deviations of published codes, separated by commas: no-unit-delay, nominal-numerical-part, root-mean-square,
    /// half-scale, judged-by-estimate, uniform-plants, core-integrates
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    deviate: Vec<String>,
    /// What is tested: linear (the problem's own), degrading or pinched
    #[arg(long, default_value = "linear", value_name = "NAME")]
    specimen: String,
    /// Records of the problem, separated by commas: ElCentro, Kobe, Morgan; left out: all
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    records: Vec<String>,
    /// Another ground motion; may be given several times
    #[arg(long, value_name = "FILE", conflicts_with = "records")]
    record: Vec<PathBuf>,
    /// The folder of data; left out: OUTERLOOP_DATA, else ../shared/data
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Controllers, separated by commas; left out: all. Core's methods take settings: amb/lead=1, hydraulic/mu=1.5,
    /// hydraulic/stiffness=0.7
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    controllers: Vec<String>,
    /// Perturbed plants for each case
    #[arg(long, default_value_t = 20)]
    plants: usize,
    /// Seed of plants and noise
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the targets of one record and case as a table there, for --follow
    #[arg(long, value_name = "FILE")]
    targets: Option<PathBuf>,
    /// Judge a table of commands for a table of targets: columns time_s, target_m, command_m
    #[arg(long, value_name = "FILE", conflicts_with = "targets")]
    follow: Option<PathBuf>,
    /// The case of --targets and --follow, 1 to 4
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=4))]
    case: Option<u8>,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
    /// Write report.html and rths.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Rths {
    /// Runs it.
    ///
    /// # Errors
    /// Bad input.
    pub(super) fn run(&self) -> Result<(), Failure> {
        let began = Instant::now();
        note_seed(self.seed);
        let rules = self.rules()?;
        check_plants(self.plants)?;
        let contestants = match &self.controllers[..] {
            [] => Contestant::all(),
            names => names
                .iter()
                .map(|n| Contestant::named(n).map_err(refused))
                .collect::<Result<_, _>>()?,
        };
        let records = self.load(&rules)?;
        if self.case.is_none() && (self.targets.is_some() || self.follow.is_some()) {
            return Err(Failure::input(
                "--targets and --follow: a case goes with them, as in --records ElCentro --case 1",
            ));
        }
        if let Some(case) = self.case {
            return self.by_table(usize::from(case) - 1, &records, &rules);
        }
        let bench = Bench {
            rules: &rules,
            records: &records,
            contestants: &contestants,
            plants: self.plants,
            seed: self.seed,
        };
        let rows = {
            let trials = records.len() * CASES.len() * contestants.len() * (1 + self.plants);
            let progress = Progress::over("trials", trials as u64);
            bench.rows(|n| progress.add(n as u64)).map_err(refused)?
        };
        let targets = targets(&rules, &rows);
        let seconds = began.elapsed().as_secs_f64();
        let answer = serde_json::json!({
            "rules": rules.name(), "seed": self.seed, "plants": self.plants, "targets": targets,
            "best": best(&rows), "rows": rows, "seconds": seconds,
        });
        let with_provenance = WithProvenance::of(&answer);
        if self.json {
            answer!("{}", json(&with_provenance)?);
        } else {
            print(&rules, &rows, &targets);
        }
        if let Some(folder) = &self.out {
            let page = report::of_rths(&bench, &rows, &targets)?;
            output::write_all(
                folder,
                &[
                    ("report.html", page),
                    ("rths.json", json(&with_provenance)?),
                ],
            )?;
        }
        Ok(())
    }

    fn rules(&self) -> Result<Rules, Failure> {
        let rules = match self.rules.as_str() {
            "official" => Rules::official(),
            "own" => Rules::own(),
            other => {
                return Err(Failure::input(format!(
                    "--rules {other}: accepted are official and own"
                )));
            }
        };
        self.deviate
            .iter()
            .try_fold(rules, |rules, name| rules.with(name))
            .map_err(refused)
    }

    fn load(&self, rules: &Rules) -> Result<Vec<Record>, Failure> {
        if let Some(unknown) = self.records.iter().find(|r| !RECORDS.contains(&r.as_str())) {
            return Err(Failure::input(format!(
                "--records {unknown}: accepted are {}",
                RECORDS.join(", ")
            )));
        }
        let behaviour = Behaviour::named(&self.specimen).map_err(refused)?;
        let folder = data_folder(self.data.as_deref()).join("ground-motion");
        let own = |name: &str| folder.join(format!("RTHSBENCH_{name}.csv"));
        let files: Vec<PathBuf> = match (&self.record[..], &self.records[..]) {
            ([], []) => RECORDS.map(own).into(),
            ([], names) => names.iter().map(|n| own(n)).collect(),
            (files, _) => files.to_vec(),
        };
        files
            .iter()
            .map(|path| {
                let file = GroundMotionFile::load(path, ColumnChoice::default())?;
                Ok(Record::new(
                    &file.name,
                    &file.acc_m_per_s2,
                    file.interval_s,
                    rules,
                    behaviour,
                ))
            })
            .collect()
    }

    /// `--targets` and `--follow`: one record, one case.
    fn by_table(&self, place: usize, records: &[Record], rules: &Rules) -> Result<(), Failure> {
        let [record] = records else {
            return Err(Failure::input(
                "--case: with it goes one ground motion, as in --records ElCentro --case 1",
            ));
        };
        match (&self.targets, &self.follow) {
            (Some(file), _) => output::write(file, table_of_targets(record, place)),
            (_, Some(file)) => self.judge(file, record, place, rules),
            _ => Err(Failure::input(
                "--case: belongs to --targets or --follow; all four cases are run without it",
            )),
        }
    }

    fn judge(
        &self,
        file: &Path,
        record: &Record,
        place: usize,
        rules: &Rules,
    ) -> Result<(), Failure> {
        let commands_m = commands(file, &follow::targets_m(record, place))?;
        let found = follow::judge(record, place, &commands_m, self.seed, rules).map_err(refused)?;
        if self.json {
            let mut row = serde_json::json!({
                "controller": file.display().to_string(), "case": CASES[place].number,
                "record": record.name, "J2_true": found.j2_true, "J4_true": found.j4_true,
                "within_limits": found.within_limits, "perturbed": 0, "lost": 0,
            });
            for (i, j) in found.j.iter().enumerate() {
                row[format!("J{}", i + 1)] = serde_json::json!(j);
            }
            let answer =
                serde_json::json!({ "rules": rules.name(), "seed": self.seed, "rows": [row] });
            answer!("{}", json(&WithProvenance::of(&answer))?);
            return Ok(());
        }
        println!(
            "{}, case {}, the loop not closed: the targets are those of the table.",
            record.name, CASES[place].number
        );
        for (meaning, j) in MEANING.iter().zip(found.j) {
            println!("{:>7}  {meaning}", number(j));
        }
        println!(
            "{:>7}  J2 of the displacement as it was, %",
            number(found.j2_true)
        );
        println!(
            "{:>7}  J4 of the displacement as it was, %",
            number(found.j4_true)
        );
        Ok(())
    }
}

/// The targets as a table; the commands are to be filled in.
fn table_of_targets(record: &Record, place: usize) -> String {
    let mut text = format!(
        "# {}, case {}: floor 1 of the reference structure at {RATE_HZ} Hz. A command is held until the next sample.\n\
         time_s,target_m,command_m\n",
        record.name, CASES[place].number
    );
    for (k, target_m) in follow::targets_m(record, place).iter().enumerate() {
        let _ = writeln!(text, "{:.9},{target_m:.9e},0", k as f64 / RATE_HZ);
    }
    text
}

/// The commands of a table, whose targets have to be those that were given.
fn commands(file: &Path, targets_m: &[f64]) -> Result<Vec<f64>, Failure> {
    let name = file.display().to_string();
    let text = std::fs::read_to_string(file)
        .map_err(|e| Failure::input(format!("{name}: cannot be read: {e}")))?;
    let mut table = NumberTable::parse(&name, &text)?;
    let mut take = |wanted: &str| {
        let found = table.headers.iter().position(|h| h.text == wanted);
        let place = found.ok_or_else(|| {
            table.refuse_header(format!(
                "the column `{wanted}` is missing: time_s, target_m and command_m are accepted"
            ))
        })?;
        Ok::<_, Failure>(std::mem::take(&mut table.columns[place]))
    };
    let (found_m, commands_m) = (take("target_m")?, take("command_m")?);
    let peak = targets_m.iter().fold(0.0_f64, |p, t| p.max(t.abs()));
    let other = found_m
        .iter()
        .zip(targets_m)
        .position(|(found, target)| (found - target).abs() > 1e-6 * peak);
    match other {
        None => Ok(commands_m),
        Some(row) => Err(Failure::input(format!(
            "{name}, line {}: the target {:e} m is not that of this record and case, {:e} m: write the table anew \
             with --targets",
            table.lines.get(row).copied().unwrap_or(0),
            found_m[row],
            targets_m[row]
        ))),
    }
}

fn print(rules: &Rules, rows: &[RthsRow], targets: &[Statement]) {
    println!("Rules: {}.", rules.name());
    for target in targets {
        println!("  {}", target.sentence());
    }
    match &best(rows)[..] {
        [] => {}
        [one] => println!("Least J4 as read, mean of all cases and ground motions: {one}."),
        [first, rest @ ..] => println!(
            "Least J4 as read, mean of all cases and ground motions: {first}; a tie with {}.",
            rest.join(", ")
        ),
    }
    println!("{CAUTION}\n\n{SUMMARY_LEGEND}.\n");
    for group in rows.chunk_by(|a, b| a.record == b.record) {
        println!("{}", group.first().map_or("", |r| &r.record));
        let cells = summary(group).into_iter();
        println!("{}\n", named(table(&summary_head(group)), 0, cells));
    }
    println!("J1 to J9 of every case: --json, or --out DIR for a report.");
}
