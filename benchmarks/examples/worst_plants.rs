//! How the worst of twenty drawn plants varies between draws, and which kind of draw gives the figures of an independent port.
//!
//! ```text
//! cargo run --release -p benchmarks --example worst_plants -- RTHSBENCH_ElCentro.csv
//! ```

#[allow(dead_code)] // Only its reading of a record is used.
#[path = "your_controller.rs"]
mod your_controller;

use benchmarks::rths::published::WORST_DRAWN;
use benchmarks::rths::{Benchmark, Contestant, RthsRow, Rules};

/// Number of draws of twenty plants for each case.
const SEEDS: u64 = 9;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("the record is wanted: a file of time_s,acc_g")?;
    let draws = [
        ("normal, as published", Rules::official()),
        (
            "evenly, 3 standard deviations to either side",
            Rules::official().with("uniform-plants")?,
        ),
    ];
    println!(
        "J4 of the worst of 20 drawn plants, per cent, cases 1/2/3/4: median of {SEEDS} draws (least to largest)"
    );
    for (draw, rules) in draws {
        println!("\n{draw}");
        let record = [your_controller::read(&path, &rules)?];
        let contestants: Vec<Contestant> = WORST_DRAWN
            .iter()
            .map(|(name, _)| Contestant::named(name))
            .collect::<Result<_, _>>()?;
        let mut rows: Vec<RthsRow> = Vec::new();
        for seed in 1..=SEEDS {
            let bench = Benchmark {
                rules: &rules,
                records: &record,
                contestants: &contestants,
                plants: 20,
                seed,
            };
            rows.extend(bench.rows(|_| std::ops::ControlFlow::Continue(()))?);
        }
        for (name, port) in WORST_DRAWN {
            let worst: Vec<String> = (1..=4)
                .map(|case| {
                    let mut of_case: Vec<f64> = rows
                        .iter()
                        .filter(|row| row.controller == name && row.case == case)
                        .map(|row| row.j4_worst)
                        .collect();
                    of_case.sort_by(f64::total_cmp);
                    let middle = of_case[of_case.len() / 2];
                    format!(
                        "{middle:.1} ({:.1} to {:.1})",
                        of_case[0],
                        of_case[of_case.len() - 1]
                    )
                })
                .collect();
            println!("{name:14} {}    port {port:?}", worst.join(" / "));
        }
    }
    Ok(())
}
