//! `outerloop`: runs and judges fast pseudodynamic tests.

use clap::{Parser, Subcommand};
use outerloop_cli::verb;
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
    Demo(verb::demo::Demo),
    Run(verb::run::Run),
    Compare(verb::compare::Compare),
    Check(verb::check::Check),
    MonteCarlo(verb::monte_carlo::MonteCarlo),
    Diagnose(verb::diagnose::Diagnose),
    Improve(verb::improve::Improve),
    Benchmark(verb::benchmark::Benchmark),
    Identify(verb::identify::Identify),
    Effects(verb::effects::Effects),
    Board(verb::board::Board),
}

fn main() -> ExitCode {
    // A reader that has seen enough, such as `head`, ends the program and is no error.
    sigpipe::reset();
    let outcome = match Arguments::parse().verb {
        Verb::Demo(v) => v.go(),
        Verb::Run(v) => v.go(),
        Verb::Compare(v) => v.go(),
        Verb::Check(v) => v.go(),
        Verb::MonteCarlo(v) => v.go(),
        Verb::Diagnose(v) => v.go(),
        Verb::Improve(v) => v.go(),
        Verb::Benchmark(v) => v.go(),
        Verb::Identify(v) => v.go(),
        Verb::Effects(v) => v.go(),
        Verb::Board(v) => v.go(),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("outerloop: {failure}");
            failure.exit()
        }
    }
}
