//! `bit-flips --image IMAGE`: effects of single bit flips on a running test, as a table with an upper bound.

use clap::Parser;
use emu::Firmware;
use emu::flips::{Outcome, Table, Target, Trials, run};
use std::path::PathBuf;
use std::process::ExitCode;

/// Flip single bits while a test runs on the flashed image for one actuator and external converters
#[derive(Parser, Debug)]
#[command(version, about)]
struct Arguments {
    /// The image as it is flashed, an ELF file; left out: the file that OUTERLOOP_IMAGE_16 names
    #[arg(long)]
    image: Option<PathBuf>,
    /// Number of flips
    #[arg(long, default_value_t = 2000)]
    flips: usize,
    /// Seed of the random draw
    #[arg(long, default_value_t = 3)]
    seed: u64,
    /// Number of simultaneous processes
    #[arg(long, default_value_t = 2)]
    jobs: usize,
    /// Print each flip on a line of its own, with its number, on standard error
    #[arg(long)]
    each: bool,
    /// Exit with 1 if more flips than this number are dangerous, or if no flip of a core register reset the board: then they hit
    /// nothing in use; left out: the table is printed and nothing fails
    #[arg(long)]
    at_most: Option<usize>,
    /// Only the flip with this number, from 0
    #[arg(long)]
    number: Option<usize>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match table(&arguments) {
        Ok(table) => {
            print!("{table}");
            match arguments.at_most.and_then(|most| failed(&table, most)) {
                None => ExitCode::SUCCESS,
                Some(why) => {
                    eprintln!("bit-flips: {why}");
                    ExitCode::FAILURE
                }
            }
        }
        Err(sentence) => {
            eprintln!("bit-flips: {sentence}");
            ExitCode::from(2)
        }
    }
}

/// Why a table is no proof that at most so many flips are dangerous.
fn failed(table: &Table, most: usize) -> Option<String> {
    let found = table.dangerous();
    if found > most {
        return Some(format!(
            "{found} flips are dangerous: accepted are at most {most}"
        ));
    }
    let resets = table.count(Some(Target::Core), Outcome::Reset);
    (resets == 0).then(|| {
        "no flip of a core register reset the board: accepted are flips that hit what is in use"
            .into()
    })
}

fn table(arguments: &Arguments) -> Result<Table, String> {
    let image = arguments.image.clone();
    let image = image.or_else(|| std::env::var_os("OUTERLOOP_IMAGE_16").map(PathBuf::from));
    let image = image.ok_or("no image: accepted is --image with the ELF file of nucleo_f429zi_16, which `scripts/images` makes")?;
    let firmware = Firmware::read(&image)?;
    let trials = Trials {
        flips: arguments.flips,
        seed: arguments.seed,
        jobs: arguments.jobs,
        number: arguments.number,
    };
    let each = arguments.each;
    run(&firmware, &trials, move |line| {
        if each {
            eprintln!("{line}");
        }
    })
}
