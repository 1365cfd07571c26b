//! A controller of another crate on the benchmark problem of real-time hybrid simulation: one file, closed loop, all four
//! cases, with drawn plants. Copy it into your own crate, which depends on `benchmarks`, and put your law into `command_m`.
//!
//! ```text
//! cargo run --release -p benchmarks --example your_controller -- RECORD.csv      # time_s,acc_g, as RTHSBENCH_ElCentro.csv
//! ```
//!
//! Without a record the ground motion is a few sines. `outerloop benchmark rths` prints the rows of the other controllers.

use benchmarks::rths::controller::{Controller, ControllerInput, DeclaredPlant, Outside};
use benchmarks::rths::yielding::Behaviour;
use benchmarks::rths::{Benchmark, Contestant, GroundRecord, RATE_HZ, RthsRow, Rules};

/// The target extrapolated linearly by 25 ms: what one would try first.
struct Ahead {
    samples: f64,
    last_m: f64,
}

impl Controller for Ahead {
    fn command_m(&mut self, seen: &ControllerInput) -> f64 {
        let target_m = seen.floors_m[0];
        let step_m = target_m - self.last_m;
        self.last_m = target_m;
        target_m + self.samples * step_m
    }
}

/// Its entry in the table.
static ENTRY: Outside = Outside {
    name: "ahead",
    prior_knowledge: "the delay",
    make: |_: &DeclaredPlant| {
        Box::new(Ahead {
            samples: 0.025 * RATE_HZ,
            last_m: 0.0,
        })
    },
};

/// Its rows and those of the published controller, one for each case.
pub fn rows(
    record: GroundRecord,
    rules: &Rules,
    plants: usize,
) -> Result<Vec<RthsRow>, benchmarks::Refused> {
    let bench = Benchmark {
        rules,
        records: &[record],
        contestants: &[
            Contestant::from_outside(&ENTRY),
            Contestant::named("pi-phase-lead")?,
        ],
        plants,
        seed: 1,
    };
    bench.rows(|_| std::ops::ControlFlow::Continue(()))
}

/// A few sines that swell and fade, for a first look without the problem's records.
pub fn sines(rules: &Rules) -> GroundRecord {
    let points: Vec<f32> = (0..600)
        .map(|i| {
            let t = f64::from(i) * 0.01;
            let wave = (14.0 * t).sin() + 0.5 * (23.0 * t).sin();
            (4.0 * wave * (0.52 * t).sin()) as f32
        })
        .collect();
    GroundRecord::new("sines", &points, 0.01, rules, Behaviour::Linear)
}

/// Interval (s) and accelerations (m/s^2) of a record with two columns, time in s and acceleration in g, below a header line.
pub fn points(path: &str) -> Result<(f64, Vec<f32>), Box<dyn std::error::Error>> {
    let text = std::fs::read_to_string(path)?;
    let mut rows = Vec::new();
    for line in text.lines().skip(1).filter(|line| !line.trim().is_empty()) {
        let (time, acc) = line.split_once(',').ok_or("two columns are wanted")?;
        rows.push((time.trim().parse::<f64>()?, acc.trim().parse::<f64>()?));
    }
    let [(first, _), (second, _), ..] = rows[..] else {
        return Err("a record has two points at least".into());
    };
    let points = rows.iter().map(|(_, g)| (9.80665 * g) as f32).collect();
    Ok((second - first, points))
}

/// The same as a record of the problem.
pub fn read(path: &str, rules: &Rules) -> Result<GroundRecord, Box<dyn std::error::Error>> {
    let (interval_s, points) = points(path)?;
    let name = path.rsplit('/').next().unwrap_or(path);
    Ok(GroundRecord::new(
        name,
        &points,
        interval_s,
        rules,
        Behaviour::Linear,
    ))
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let rules = Rules::official();
    let record = match std::env::args().nth(1) {
        Some(path) => read(&path, &rules)?,
        None => sines(&rules),
    };
    println!("controller      case     J2 %     J4 %   J4 of the worst of 8 drawn plants   lost");
    for row in rows(record, &rules, 8)? {
        println!(
            "{:14} {:5} {:8.2} {:8.2} {:12.2} {:28}",
            row.controller, row.case, row.j[1], row.j[3], row.j4_worst, row.lost
        );
    }
    Ok(())
}
