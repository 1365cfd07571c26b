//! `outerloop benchmark`: the benchmark problems of the field, one file a problem.

mod rths;

use crate::failure::Failure;

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
}

impl Benchmark {
    /// Runs it.
    ///
    /// # Errors
    /// Bad input.
    pub fn go(&self) -> Result<(), Failure> {
        match &self.problem {
            Problem::Rths(problem) => problem.go(),
        }
    }
}

/// A benchmark that cannot be run.
fn refused(why: benchmarks::Refused) -> Failure {
    Failure::input(why.to_string())
}
