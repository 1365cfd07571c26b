//! What both benchmarks need.

use crate::terminal::{Table, table};
use benchmarks::goal::{GOAL_HEAD, Goal};
use comfy_table::TableComponent;
use experiment::failure::Failure;
use std::path::{Path, PathBuf};

/// A benchmark that cannot be run.
pub(super) fn refused(why: benchmarks::Refused) -> Failure {
    Failure::input(why.to_string())
}

/// The ground motions of both problems.
pub(super) const RECORDS: [&str; 3] = ["ElCentro", "Kobe", "Morgan"];

/// Refuses more drawn plants than anybody waits for.
pub(super) fn check_plants(plants: usize) -> Result<(), Failure> {
    if plants > 1000 {
        let sentence = format!("--plants {plants}: accepted are 0 to 1000");
        return Err(Failure::input(sentence));
    }
    Ok(())
}

/// The folder of third-party data: as given, else `OUTERLOOP_DATA`, else beside the checkout.
pub(super) fn data_folder(given: Option<&Path>) -> PathBuf {
    given.map(Path::to_owned).unwrap_or_else(|| {
        std::env::var_os("OUTERLOOP_DATA").map_or_else(|| "../shared/data".into(), PathBuf::from)
    })
}

/// A table without lines between its rows.
pub(super) fn without_lines(head: &[&str], rows: impl Iterator<Item = Vec<String>>) -> Table {
    let mut t = table(head);
    for lines in [
        TableComponent::HorizontalLines,
        TableComponent::MiddleIntersections,
        TableComponent::LeftBorderIntersections,
        TableComponent::RightBorderIntersections,
    ] {
        t.remove_style(lines);
    }
    t.add_rows(rows);
    t
}

/// What was asked for, what was found, by how much it is missed; below it the reasons.
pub(super) fn print_goals(goals: &[Goal]) {
    if goals.is_empty() {
        return;
    }
    println!(
        "{}\n",
        without_lines(&GOAL_HEAD, goals.iter().map(Goal::cells))
    );
    for target in goals.iter().filter(|t| !t.reached()) {
        println!("Missed. {}\n", target.sentence());
    }
}
