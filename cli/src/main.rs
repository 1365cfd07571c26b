//! `outerloop`: runs and judges fast pseudodynamic tests.

mod bench;
mod failure;
mod files;
mod report;
mod summary;
mod terminal;
mod verb;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// The outer loop of a fast pseudodynamic test
#[derive(Parser, Debug)]
#[command(name = "outerloop", version, about)]
struct Arguments {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand, Debug)]
enum Verb {
    Run(verb::run::Run),
    Compare(verb::compare::Compare),
    Demo(verb::demo::Demo),
}

fn main() -> ExitCode {
    let outcome = match Arguments::parse().verb {
        Verb::Run(v) => v.go(),
        Verb::Compare(v) => v.go(),
        Verb::Demo(v) => v.go(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("outerloop: {failure}");
            failure.exit()
        }
    }
}
