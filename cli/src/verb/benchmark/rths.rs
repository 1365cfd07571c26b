//! `outerloop benchmark rths`: the benchmark problem of real-time hybrid simulation.

mod by_table;

use super::command_table;
use super::shared::{RECORDS, check_plants, data_file, refused, require_some, tell};
use crate::answer::benchmark::of_rths;
use crate::provenance::{WithProvenance, note_seed};
use crate::terminal::{Progress, interrupt};
use crate::verb::{hand_over_tests, no_files, require_all_ran};
use benchmarks::rths::case::CASES;
use benchmarks::rths::criteria::MEANING;
use benchmarks::rths::verdict::best;
use benchmarks::rths::yielding::Behaviour;
use benchmarks::rths::{Benchmark, Contestant, GroundRecord, RthsRow, Rules};
use experiment::failure::Failure;
use experiment::files::ground_motion::{ColumnChoice, GroundMotionFile};
use experiment::files::look_ahead;
use schemars::JsonSchema;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// The answer; pairs of a name and a figure are J1 to J9.
#[derive(Serialize, JsonSchema)]
pub struct RthsAnswer<'a> {
    rules: String,
    seed: u64,
    /// Perturbed plants for each case.
    plants: usize,
    /// The controllers whose mean J4 is the least.
    best: Vec<String>,
    rows: &'a [RthsRow],
    /// The nominal plant with a specimen that loses stiffness and strength; without `--specimen` only.
    #[serde(skip_serializing_if = "Option::is_none")]
    degrading: Option<&'a [RthsRow]>,
    /// The same with a specimen that also slips around zero.
    #[serde(skip_serializing_if = "Option::is_none")]
    pinched: Option<&'a [RthsRow]>,
    seconds: f64,
    /// What J1 to J9 mean.
    criteria: [&'static str; 9],
}

#[derive(clap::Args, Debug)]
pub(super) struct Rths {
    /// Rules: the problem's own, or a simpler set in which core integrates, the numerical part is nominal and criteria are root mean squares
    #[arg(long, default_value = "official", value_name = "official|own")]
    rules: String,
    /// Deviations from the problem in published codes, separated by commas: no-unit-delay, nominal-numerical-part, root-mean-square,
    /// half-scale, judged-by-estimate, uniform-plants, core-integrates
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    deviate: Vec<String>,
    /// What is tested: linear (the problem's own), degrading or pinched; left out: linear, and beside it the nominal plant
    /// with the others
    #[arg(long, value_name = "NAME")]
    specimen: Option<String>,
    /// Records of the problem, separated by commas: ElCentro, Kobe, Morgan; left out: all
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    records: Vec<String>,
    /// A ground motion in place of the problem's; may be given several times
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

/// Rows of a benchmark, and of each yielding specimen run in addition.
type Trials = (Vec<RthsRow>, Vec<Vec<RthsRow>>);

impl Rths {
    /// Runs the benchmark.
    ///
    /// # Errors
    /// Bad input.
    pub(super) fn run(&self) -> Result<(), Failure> {
        let names = ["report.html", "rths.json"];
        let out = look_ahead::folder(self.out.as_deref(), &names)?;
        command_table::will_write(self.targets.as_deref())?;
        let began = Instant::now();
        note_seed(self.seed);
        let rules = self.rules()?;
        check_plants(self.plants)?;
        let contestants = self.contestants()?;
        let behaviour = match &self.specimen {
            Some(name) => Behaviour::named(name).map_err(refused)?,
            None => Behaviour::Linear,
        };
        let records = self.load(&rules, behaviour)?;
        if self.case.is_none() && (self.targets.is_some() || self.follow.is_some()) {
            return Err(Failure::input(
                "--targets and --follow: a case goes with them, as in --records ElCentro --case 1",
            ));
        }
        if let Some(case) = self.case {
            return self.by_table(usize::from(case) - 1, &records, &rules, out.as_deref());
        }
        let bench = Benchmark {
            rules: &rules,
            records: &records,
            contestants: &contestants,
            plants: self.plants,
            seed: self.seed,
        };
        let beside: &[Behaviour] = match self.specimen {
            None => &[Behaviour::Degrading, Behaviour::Pinched],
            Some(_) => &[],
        };
        let (rows, yielding) = self.trials(&bench, beside)?;
        require_some(rows.len())?;
        let of = |wanted| {
            let mut all = beside.iter().zip(&yielding);
            all.find_map(|(behaviour, rows)| (*behaviour == wanted).then_some(&rows[..]))
        };
        let answer = RthsAnswer {
            rules: rules.name(),
            seed: self.seed,
            plants: self.plants,
            best: best(&rows),
            rows: &rows,
            degrading: of(Behaviour::Degrading),
            pinched: of(Behaviour::Pinched),
            seconds: began.elapsed().as_secs_f64(),
            criteria: MEANING,
        };
        let asked = records.len() * CASES.len() * contestants.len() * (1 + beside.len());
        let ran = rows.len() + yielding.iter().map(Vec::len).sum::<usize>();
        hand_over_tests(
            (ran, asked),
            (out.as_deref(), self.json),
            no_files,
            |page| {
                of_rths(&bench, &rows, &yielding, page)?
                    .with_figures("rths.json", &WithProvenance::of(&answer))
            },
        )?;
        require_all_ran(ran, asked)
    }

    fn contestants(&self) -> Result<Vec<Contestant>, Failure> {
        if self.controllers.is_empty() {
            return Ok(Contestant::all());
        }
        let named = self.controllers.iter().map(|n| Contestant::named(n));
        named.map(|c| c.map_err(refused)).collect()
    }

    /// The rows of `bench`, and those of the nominal rig with each further specimen in `beside`.
    fn trials(&self, bench: &Benchmark<'_>, beside: &[Behaviour]) -> Result<Trials, Failure> {
        let plants = 1 + self.plants + beside.len();
        let trials = bench.records.len() * CASES.len() * bench.contestants.len() * plants;
        let progress = Progress::over("trials", trials as u64);
        let one_done = |n: usize| tell(&progress, n);
        interrupt::watch();
        let rows = bench.rows(one_done).map_err(refused)?;
        let nominal = beside.iter().map(|&behaviour| {
            let records = self.load(bench.rules, behaviour)?;
            let nominal = Benchmark {
                records: &records,
                plants: 0,
                ..*bench
            };
            nominal.rows(one_done).map_err(refused)
        });
        let yielding = nominal.collect::<Result<Vec<_>, Failure>>()?;
        Ok((rows, yielding))
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

    fn load(&self, rules: &Rules, behaviour: Behaviour) -> Result<Vec<GroundRecord>, Failure> {
        if let Some(unknown) = self.records.iter().find(|r| !RECORDS.contains(&r.as_str())) {
            return Err(Failure::input(format!(
                "--records: `{unknown}` is unknown: accepted are {}",
                RECORDS.join(", ")
            )));
        }
        let own = |name: &str| {
            let path = format!("ground-motion/RTHSBENCH_{name}.csv");
            data_file(self.data.as_deref(), &path)
        };
        let files: Vec<PathBuf> = match (&self.record[..], &self.records[..]) {
            ([], []) => RECORDS.into_iter().map(own).collect(),
            ([], names) => names.iter().map(|n| own(n)).collect(),
            (files, _) => files.to_vec(),
        };
        files
            .iter()
            .map(|path| {
                let file = GroundMotionFile::load(path, ColumnChoice::default())?;
                Ok(GroundRecord::new(
                    &file.name,
                    &file.acc_m_per_s2,
                    file.interval_s,
                    rules,
                    behaviour,
                ))
            })
            .collect()
    }
}
