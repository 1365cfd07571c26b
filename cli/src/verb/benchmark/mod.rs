//! `outerloop benchmark`: the benchmark problems of the field, one file per problem.

mod command_table;
mod followed;
mod marths;
mod rths;
mod shared;

pub use followed::{Followed, FollowedMarthsRow, FollowedRthsRow};
pub use marths::MarthsAnswer;
pub use rths::RthsAnswer;

use experiment::failure::Failure;

/// Run a benchmark problem of the field
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
    /// Runs the chosen problem.
    ///
    /// # Errors
    /// Bad input.
    pub fn run(&self) -> Result<(), Failure> {
        match &self.problem {
            Problem::Rths(problem) => problem.run(),
            Problem::Marths(problem) => problem.run(),
        }
    }
}
