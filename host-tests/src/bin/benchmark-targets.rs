//! Goals set for this program in the benchmark problems, compared with the results of `outerloop benchmark`.

use clap::Parser;
use comfy_table::{Table, presets};
use experiment::failure::Failure;
use experiment::files::read;
use host_tests::targets::{GOAL_HEAD, Goal, goals};
use std::path::PathBuf;
use std::process::ExitCode;

/// Judge answers of `outerloop benchmark rths --json` and `benchmark marths --json` by their targets: exit status 1 if a target
/// is missed, 2 for bad input
#[derive(Parser, Debug)]
struct Arguments {
    /// rths.json or marths.json of the command's --out, or `-` for an answer on standard input
    #[arg(required = true)]
    answers: Vec<PathBuf>,
}

fn main() -> ExitCode {
    match judged(&Arguments::parse().answers) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(failure) => {
            eprintln!("benchmark-targets: {failure}");
            ExitCode::from(2)
        }
    }
}

/// Whether all goals that the answers cover are reached.
fn judged(answers: &[PathBuf]) -> Result<bool, Failure> {
    let mut reached = true;
    for file in answers {
        let name = file.display();
        let refused = |e: &dyn std::fmt::Display| Failure::input(format!("{name}: {e}"));
        let answer = serde_json::from_str(&read(file)?).map_err(|e| refused(&e))?;
        let goals = goals(&answer).map_err(|e| refused(&e))?;
        if goals.is_empty() {
            println!(
                "{name}: nothing was asked for of these rows: other rules, or controllers that nothing was asked of."
            );
        } else {
            println!("{}", table(&goals));
        }
        for goal in goals.iter().filter(|goal| !goal.reached()) {
            reached = false;
            println!("Missed. {}", goal.sentence());
        }
    }
    Ok(reached)
}

fn table(goals: &[Goal]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::UTF8_HORIZONTAL_ONLY);
    table.set_content_arrangement(comfy_table::ContentArrangement::Dynamic);
    table.set_header(GOAL_HEAD);
    table.add_rows(goals.iter().map(Goal::cells));
    table
}
