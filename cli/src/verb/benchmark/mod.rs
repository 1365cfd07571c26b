//! `outerloop benchmark`: the benchmark problems of the field, one file a problem.

mod marths;
mod rths;

use crate::failure::Failure;
use comfy_table::{CellAlignment, Table, TableComponent};
use std::path::{Path, PathBuf};

/// A benchmark of the field
#[derive(clap::Args, Debug)]
pub struct Benchmark {
    #[command(subcommand)]
    problem: Problem,
}

#[derive(clap::Subcommand, Debug)]
enum Problem {
    /// Real-time hybrid simulation (Silva et al. 2020): four cases, J1 to J9, perturbed plants
    Rths(rths::Rths),
    /// Multi-axial real-time hybrid simulation (Condori Uribe et al. 2023): two coupled actuators, drawn plants
    Marths(marths::Marths),
}

impl Benchmark {
    /// Runs it.
    ///
    /// # Errors
    /// Bad input.
    pub fn go(&self) -> Result<(), Failure> {
        match &self.problem {
            Problem::Rths(problem) => problem.go(),
            Problem::Marths(problem) => problem.go(),
        }
    }
}

/// A benchmark that cannot be run.
fn refused(why: benchmarks::Refused) -> Failure {
    Failure::input(why.to_string())
}

/// The folder of third-party data: as given, else `OUTERLOOP_DATA`, else beside the checkout.
fn data_folder(given: Option<&Path>) -> PathBuf {
    given.map(Path::to_owned).unwrap_or_else(|| {
        std::env::var_os("OUTERLOOP_DATA").map_or_else(|| "../shared/data".into(), PathBuf::from)
    })
}

/// A table without lines between its rows, names in column `name`.
fn named(mut t: Table, name: usize, rows: impl Iterator<Item = Vec<String>>) -> Table {
    for lines in [
        TableComponent::HorizontalLines,
        TableComponent::MiddleIntersections,
        TableComponent::LeftBorderIntersections,
        TableComponent::RightBorderIntersections,
    ] {
        t.remove_style(lines);
    }
    t.add_rows(rows);
    if let Some(column) = t.column_mut(name) {
        column.set_cell_alignment(CellAlignment::Left);
    }
    t
}
