//! Every compensation on one bench: delays of 1 to 60 ms, several actuators and specimens, noise, and wrong declarations.

use clap::Parser;
use comfy_table::{Table, presets};
use experiment::Experiment;
use experiment::failure::Failure;
use experiment::files::ground_motion::{ColumnChoice, GroundMotionFile};
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::numbers::percent;
use host_tests::compensations::condition::{Condition, Family, yielding};
use host_tests::compensations::standing::Standing;
use host_tests::compensations::{self, standing};
use indicatif::ProgressBar;
use std::path::PathBuf;
use std::process::ExitCode;

/// Run every compensation on the same bench of rigs, in place of the test file's rig
#[derive(Parser, Debug)]
struct Arguments {
    /// The test file: its structure, loop and duration
    test: PathBuf,
    /// A ground motion; may be given several times
    #[arg(long, value_name = "FILE")]
    record: Vec<PathBuf>,
    /// Compensations, separated by commas; left out: all
    #[arg(long, value_delimiter = ',', value_name = "A,B,...")]
    compensations: Vec<String>,
    /// Seed of everything random
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Seconds of model time; left out: as the test file says, else the whole record
    #[arg(long, value_name = "S")]
    duration: Option<f64>,
    /// One JSON object on standard output and nothing else: every test, and the standings
    #[arg(long)]
    json: bool,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("compensation-bench: {failure}");
            failure.exit()
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), Failure> {
    let test = TestFile::load(&arguments.test, &[])?;
    let contestants = match &arguments.compensations[..] {
        [] => compensations::contestants(),
        names => names
            .iter()
            .map(|n| experiment::method(n))
            .collect::<Result<_, _>>()?,
    };
    let motions = match &arguments.record[..] {
        [] => vec![near_fault()],
        files => files
            .iter()
            .map(|file| GroundMotionFile::load(file, ColumnChoice::default()))
            .collect::<Result<_, _>>()?,
    };
    let experiments = motions
        .iter()
        .map(|motion| Experiment::new(test.clone(), motion, arguments.duration))
        .collect::<Result<Vec<_>, _>>()?;
    let conditions = Condition::all(&test.config, &yielding(&test.plant.specimen));
    let tests = experiments.len() * conditions.len() * contestants.len();
    let progress = ProgressBar::new(tests as u64);
    let rows = compensations::run(
        &experiments,
        &conditions,
        &contestants,
        arguments.seed,
        || progress.inc(1),
    )?;
    progress.finish_and_clear();
    let standings = standing::of(&rows);
    if arguments.json {
        let all = serde_json::json!({ "rows": rows, "standings": standings });
        println!("{all:#}");
        return Ok(());
    }
    println!(
        "{} tests: {} compensations, {} rigs, {} ground motions. Geometric means of eps_rms, Eq 18; a test that tripped or ran \
         away counts as 100 %.\n",
        rows.len(),
        contestants.len(),
        conditions.len(),
        experiments.len()
    );
    println!("{}", table(&standings));
    Ok(())
}

/// The best mean first.
fn table(standings: &[Standing]) -> Table {
    let families = Family::ALL.map(Family::name);
    let head = [
        &["compensation", "mean"],
        &families[..],
        &["worst", "best in", "failed"],
    ];
    let mut table = Table::new();
    table
        .load_preset(presets::ASCII_MARKDOWN)
        .set_header(head.concat());
    for s in standings {
        let mut cells = vec![s.compensation.to_owned(), percent(s.mean)];
        cells.extend(s.by_family.iter().map(|e| percent(*e)));
        cells.push(percent(s.worst));
        cells.push(format!("{} of {}", s.best_in, s.tests));
        cells.push(s.failed.to_string());
        table.add_row(cells);
    }
    table
}
