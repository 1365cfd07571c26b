//! A controller of another crate on the multi-axial benchmark problem: one file, closed loop, with drawn plants. Copy it into
//! your own crate, which depends on `benchmarks`, and put your law into `command`.
//!
//! ```text
//! cargo run --release -p benchmarks --example your_pair -- DATA/marths DATA/ground-motion/RTHSBENCH_ElCentro.csv
//! ```
//!
//! The folder holds the problem's own files: `K_matrix.csv`, `M_matrix.csv`, `initial_parameters.csv`. `outerloop benchmark
//! marths` prints the rows of the other controllers.

#[allow(dead_code)] // Only its reading of a record is used.
#[path = "your_controller.rs"]
mod your_controller;

use benchmarks::marths::RATE_HZ;
use benchmarks::marths::bench::{self, MarthsRow, Problem};
use benchmarks::marths::contestants::PairContestant;
use benchmarks::marths::controller::{OutsidePair, PairController, TargetSample};
use benchmarks::marths::table::{HEAD, cells};
use std::error::Error;
use std::path::Path;

/// Each target extrapolated linearly by its actuator's delay: what one would try first. The actuators are coupled, which this
/// law does not know.
struct Ahead {
    samples: [f64; 2],
    last_m: [f64; 2],
}

impl PairController for Ahead {
    fn command(&mut self, target: &TargetSample) -> [f64; 2] {
        let command_m = [0, 1].map(|i| {
            let now_m = target.stroke_m[i];
            now_m + self.samples[i] * (now_m - self.last_m[i])
        });
        self.last_m = target.stroke_m;
        command_m
    }
}

/// Its entry.
static ENTRY: OutsidePair = OutsidePair {
    name: "ahead",
    make: || {
        Box::new(Ahead {
            samples: [0.048, 0.020].map(|late_s| late_s * RATE_HZ),
            last_m: [0.0; 2],
        })
    },
};

/// Its row and the one for sending the targets unchanged.
pub fn rows(folder: &Path, record: &str, plants: usize) -> Result<Vec<MarthsRow>, Box<dyn Error>> {
    let read = |name: &str| std::fs::read_to_string(folder.join(name));
    let problem = Problem::parse(
        &read("K_matrix.csv")?,
        &read("M_matrix.csv")?,
        &read("initial_parameters.csv")?,
    )?;
    let (interval_s, points) = your_controller::points(record)?;
    let points: Vec<f64> = points.into_iter().map(f64::from).collect();
    let name = record.rsplit('/').next().unwrap_or(record);
    let record = problem.record(name, &points, interval_s)?;
    let contestants = [PairContestant::None, PairContestant::Outside(&ENTRY)];
    Ok(bench::rows(
        &problem,
        &[record],
        &contestants,
        plants,
        1,
        |_| std::ops::ControlFlow::Continue(()),
    )?)
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(folder), Some(record)) = (arguments.next(), arguments.next()) else {
        return Err(
            "wanted: the folder of the problem's files, and a record of time_s,acc_g".into(),
        );
    };
    let line = |cells: Vec<String>| {
        let cells: Vec<String> = cells.iter().map(|c| format!("{c:>13}")).collect();
        println!("{}", cells.join(""));
    };
    line(HEAD.map(String::from).to_vec());
    for row in rows(Path::new(&folder), &record, 8)? {
        line(cells(&row));
    }
    Ok(())
}
