//! `outerloop benchmark marths`: the multi-axial benchmark problem of real-time hybrid simulation.

mod by_table;

use super::command_table;
use super::shared::{RECORDS, check_plants, data_file, refused, require_some, tell};
use crate::answer::benchmark::of_marths;
use crate::answer::benchmark::physical_part::{self, PhysicalPartEstimate};
use crate::provenance::{WithProvenance, note_seed};
use crate::terminal::{self, Progress, interrupt};
use crate::verb::{hand_over_tests, require_all_ran};
use benchmarks::marths::bench::{self, MarthsRecord, MarthsRow, Problem};
use benchmarks::marths::contestants::{ALL, PairContestant};
use benchmarks::marths::criteria::MEANING;
use benchmarks::marths::declared::Floor;
use diagnosis::CoupledDiagnosis;
use experiment::failure::Failure;
use experiment::files::ground_motion::{ColumnChoice, GroundMotionFile};
use experiment::files::{look_ahead, read};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The answer; pairs are actuator 1 and 2, or x and rotation.
#[derive(Serialize, JsonSchema)]
pub struct MarthsAnswer<'a> {
    rules: &'static str,
    seed: u64,
    /// Drawn plants for each controller and record.
    plants: usize,
    rows: &'a [MarthsRow],
    /// What J1 to J9 mean.
    criteria: [&'static str; 9],
    /// The model that is subtracted as physical; null: the problem's own.
    model: Option<&'a Path>,
    declared_part: Vec<DeclaredByRecord<'a>>,
    seconds: f64,
}

/// What the loop's record of a ground motion says of the declared part.
#[derive(Serialize, JsonSchema)]
struct DeclaredByRecord<'a> {
    record: &'a str,
    floors: &'a [Floor],
    diagnosis: &'a CoupledDiagnosis,
}

#[derive(clap::Args, Debug)]
pub(super) struct Marths {
    /// Records, separated by commas: ElCentro, Kobe, Morgan; left out: all three
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    records: Vec<String>,
    /// Controllers, separated by commas; left out: all
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    controllers: Vec<String>,
    /// The folder of data; left out: OUTERLOOP_DATA, else ../shared/data
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// What is subtracted as physical, in place of what the problem declares: a model with a table [coupled], such as
    /// `diagnose --save-model` makes of declared.toml and record-NAME.csv of this command's --out
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Write the strokes that one record asks for as a table there, for --follow
    #[arg(long, value_name = "FILE", conflicts_with = "model")]
    targets: Option<PathBuf>,
    /// Judge a table of commands for a table of targets: columns time_s, target_m, target2_m, command_m, command2_m
    #[arg(long, value_name = "FILE", conflicts_with_all = ["targets", "model"])]
    follow: Option<PathBuf>,
    /// Drawn plants for each controller and record
    #[arg(long, default_value_t = 20)]
    plants: usize,
    /// Seed of the sensors' noise; the drawn plants are always the same
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
    /// Write report.html, marths.json, the loop's record of each ground motion and the declared physical part there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

impl Marths {
    /// Runs the benchmark.
    ///
    /// # Errors
    /// Bad input; missing files of the problem.
    pub(super) fn run(&self) -> Result<(), Failure> {
        let records = self.names()?;
        let files = ["report.html", "marths.json", "declared.toml"].map(str::to_owned);
        let files = files
            .into_iter()
            .chain(records.iter().copied().map(of_record));
        let out = look_ahead::folder(self.out.as_deref(), &files.collect::<Vec<_>>())?;
        command_table::will_write(self.targets.as_deref())?;
        let begin = std::time::Instant::now();
        note_seed(self.seed);
        check_plants(self.plants)?;
        let contestants = self.contestants()?;
        let mut problem = load(self.data.as_deref())?;
        if let Some(file) = &self.model {
            problem = problem.with(&physical_part::load(file)?);
        }
        let problem = problem;
        let records = records.into_iter().map(|name| self.record(&problem, name));
        let records = records.collect::<Result<Vec<MarthsRecord>, Failure>>()?;
        if self.targets.is_some() || self.follow.is_some() {
            return self.by_table(&records, out.as_deref());
        }
        let rows = self.trials(&problem, &records, &contestants)?;
        require_some(rows.len())?;
        let parts = terminal::while_waiting("diagnosing the loop's records", || {
            records
                .iter()
                .map(|r| Ok((r, PhysicalPartEstimate::of(&problem, r, self.seed)?)))
                .collect::<Result<Vec<_>, Failure>>()
        })?;
        let declared = parts.iter().map(|(record, found)| DeclaredByRecord {
            record: &record.name,
            floors: &found.floors,
            diagnosis: &found.diagnosis,
        });
        let answer = MarthsAnswer {
            rules: "official",
            seed: self.seed,
            plants: self.plants,
            rows: &rows,
            criteria: MEANING,
            model: self.model.as_deref(),
            declared_part: declared.collect(),
            seconds: begin.elapsed().as_secs_f64(),
        };
        let files = || {
            let declared = physical_part::to_toml(&problem.part)?;
            let of_records = parts.iter();
            let of_records = of_records.map(|(r, found)| (of_record(&r.name), found.csv(&problem)));
            let declared = [("declared.toml".to_owned(), declared)];
            Ok(declared.into_iter().chain(of_records).collect())
        };
        let (drawn, asked) = ((self.plants, self.seed), (out.as_deref(), self.json));
        let ran = (rows.len(), records.len() * contestants.len());
        hand_over_tests(ran, asked, files, |page| {
            let mut document = of_marths(&problem, &parts, &rows, drawn, page)?;
            if let Some(file) = &self.model {
                let warning = format!(
                    "Not by the problem's rules: {} is subtracted as physical. Masses at rotations are not: the reference has none \
                     there, and less than none cannot be integrated.",
                    file.display()
                );
                document.tell_first(warning.clone());
                document.warn_first(warning);
            }
            document.with_figures("marths.json", &WithProvenance::of(&answer))
        })?;
        require_all_ran(ran.0, ran.1)
    }

    fn contestants(&self) -> Result<Vec<PairContestant>, Failure> {
        if self.controllers.is_empty() {
            return Ok(ALL.iter().map(|c| c.0).collect());
        }
        let named = self.controllers.iter().map(|n| PairContestant::named(n));
        named.map(|c| c.map_err(refused)).collect()
    }

    fn trials(
        &self,
        problem: &Problem,
        records: &[MarthsRecord],
        contestants: &[PairContestant],
    ) -> Result<Vec<MarthsRow>, Failure> {
        let drawn = contestants
            .iter()
            .filter(|c| **c != PairContestant::Perfect);
        let trials = records.len() * (contestants.len() + drawn.count() * self.plants);
        let progress = Progress::over("trials", trials as u64);
        let one_done = |n| tell(&progress, n);
        interrupt::watch();
        bench::rows(
            problem,
            records,
            contestants,
            self.plants,
            self.seed,
            one_done,
        )
        .map_err(refused)
    }

    /// The structure's response to a ground motion of the problem.
    fn record(&self, problem: &Problem, name: &str) -> Result<MarthsRecord, Failure> {
        let file = format!("ground-motion/RTHSBENCH_{name}.csv");
        let file = data_file(self.data.as_deref(), &file);
        let motion = GroundMotionFile::load(&file, ColumnChoice::default())?;
        let points: Vec<f64> = motion.acc_m_per_s2.iter().copied().map(f64::from).collect();
        let record = problem.record(name, &points, motion.interval_s);
        record.map_err(refused)
    }

    fn names(&self) -> Result<Vec<&'static str>, Failure> {
        if self.records.is_empty() {
            return Ok(RECORDS.to_vec());
        }
        self.records
            .iter()
            .map(|name| {
                RECORDS.into_iter().find(|r| r == name).ok_or_else(|| {
                    Failure::input(format!(
                        "--records: `{name}` is unknown: accepted are {}",
                        RECORDS.join(", ")
                    ))
                })
            })
            .collect()
    }
}

/// The file of the loop's record under a ground motion.
fn of_record(name: &str) -> String {
    format!("record-{name}.csv")
}

/// The problem from its files.
fn load(data: Option<&Path>) -> Result<Problem, Failure> {
    let read = |name: &str| read(&data_file(data, &format!("marths/{name}")));
    Problem::parse(
        &read("K_matrix.csv")?,
        &read("M_matrix.csv")?,
        &read("initial_parameters.csv")?,
    )
    .map_err(refused)
}
