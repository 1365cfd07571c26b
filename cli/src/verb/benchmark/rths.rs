//! `outerloop benchmark rths`: the benchmark problem of real-time hybrid simulation.

use super::{data_folder, named, refused};
use crate::failure::Failure;
use crate::files::ground_motion::{Columns, GroundMotionFile};
use crate::files::output;
use crate::report;
use crate::terminal::{Progress, table};
use crate::verb::json;
use benchmarks::rths::case::CASES;
use benchmarks::rths::table::{HEAD, LEGEND, WORST_HEAD, cells, worst_cells};
use benchmarks::rths::verdict::{CAUTION, TARGETS, Worst};
use benchmarks::rths::{BEST, Controller, Record, Row, bench};
use std::path::PathBuf;

#[derive(clap::Args, Debug)]
pub(super) struct Rths {
    /// A ground motion; may be given several times; left out: the problem's three, from the folder of data
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,
    /// The folder of data; left out: OUTERLOOP_DATA, else ../shared/data
    #[arg(long, value_name = "DIR")]
    data: Option<PathBuf>,
    /// Controllers, separated by commas; left out: all
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    controllers: Vec<String>,
    /// Perturbed plants for each case
    #[arg(long, default_value_t = 20)]
    plants: usize,
    /// Draw of the sensors' noise
    #[arg(long, default_value_t = 8)]
    draw: u64,
    /// One JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
    /// Write report.html and rths.json there
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// The records of the problem.
const RECORDS: [&str; 3] = ["RTHSBENCH_ElCentro", "RTHSBENCH_Kobe", "RTHSBENCH_Morgan"];

impl Rths {
    /// Runs it.
    ///
    /// # Errors
    /// Bad input.
    pub(super) fn go(&self) -> Result<(), Failure> {
        if self.plants > 1000 {
            return Err(Failure::input(format!(
                "--plants {}: accepted are 0 to 1000",
                self.plants
            )));
        }
        let controllers = match &self.controllers[..] {
            [] => Controller::all(),
            names => names
                .iter()
                .map(|n| Controller::named(n).map_err(refused))
                .collect::<Result<_, _>>()?,
        };
        let records = self
            .files()
            .iter()
            .map(|f| {
                let file = GroundMotionFile::load(f, Columns::default())?;
                Ok(Record::new(&file.name, &file.acc_m_per_s2, file.interval_s))
            })
            .collect::<Result<Vec<_>, Failure>>()?;
        let rows = {
            let trials = records.len() * CASES.len() * controllers.len() * (1 + self.plants);
            let progress = Progress::over("trials", trials as u64);
            bench::rows(&records, &controllers, self.plants, self.draw, || {
                progress.add(1)
            })
            .map_err(refused)?
        };
        let worst = Worst::of(&rows);
        let answer = serde_json::json!({
            "draw": self.draw, "plants": self.plants, "targets_percent": TARGETS, "worst": worst, "rows": rows,
        });
        if self.json {
            println!("{}", json(&answer)?);
        } else {
            print(&rows, &worst);
        }
        if let Some(folder) = &self.out {
            let page = report::of_rths(&records, &rows, self.draw)?;
            output::write_all(
                folder,
                &[("report.html", page), ("rths.json", json(&answer)?)],
            )?;
        }
        Ok(())
    }

    fn files(&self) -> Vec<PathBuf> {
        if !self.record.is_empty() {
            return self.record.clone();
        }
        let folder = data_folder(self.data.as_deref());
        RECORDS
            .iter()
            .map(|name| {
                folder
                    .join("ground-motion")
                    .join(name)
                    .with_extension("csv")
            })
            .collect()
    }
}

fn print(rows: &[Row], worst: &[Worst]) {
    println!("{LEGEND}.\n");
    for group in rows.chunk_by(|a, b| a.record == b.record) {
        println!("{}", group.first().map_or("", |r| &r.record));
        println!("{}\n", named(table(&HEAD), 1, group.iter().map(cells)));
    }
    println!("The worst of each controller, over all cases and ground motions");
    println!(
        "{}\n",
        named(table(&WORST_HEAD), 0, worst.iter().map(worst_cells))
    );
    for w in worst.iter().filter(|w| w.controller == BEST) {
        println!("{BEST}");
        for sentence in w.sentences() {
            println!("  {sentence}");
        }
    }
    println!("{CAUTION}");
}
