//! The program `outerloop`: its command line and its exit status.

use crate::{terminal, verb};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use experiment::failure::{EXIT_STATUSES, Failure};
use std::process::ExitCode;

#[derive(Parser, Debug)]
#[command(name = "outerloop", version, about = "Runs and judges fast pseudodynamic tests", after_help = EXIT_STATUSES)]
struct Arguments {
    /// Print no tables, sentences or progress, only JSON where it is asked for, notes and errors
    #[arg(short, long, global = true)]
    quiet: bool,
    /// Replace also files that are otherwise kept, such as records of tests on a board, emulated or not, or stopped by hand
    #[arg(long, global = true)]
    force: bool,
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand, Debug)]
enum Verb {
    Demo(verb::demo::Demo),
    Run(verb::run::Run),
    Replay(verb::replay::Replay),
    Diff(verb::diff::Diff),
    Compare(verb::compare::Compare),
    Check(verb::check::Check),
    MonteCarlo(verb::sweep::MonteCarlo),
    Sweep(verb::sweep::Sweep),
    Diagnose(verb::diagnose::Diagnose),
    Improve(verb::improve::Improve),
    Benchmark(verb::benchmark::Benchmark),
    Serve(verb::serve::Serve),
    Identify(verb::identify::Identify),
    Effects(verb::effects::Effects),
    New(verb::new::New),
    Keys(verb::keys::Keys),
    Schema(verb::keys::Schema),
    Board(verb::board::Board),
    Completions(verb::shell::Completions),
    Man(verb::shell::ManPage),
}

/// The parsed command line, or the text to print instead: the help or an error.
fn arguments() -> Result<Arguments, clap::Error> {
    let mut command = Arguments::command();
    let verbs: Vec<String> = command
        .get_subcommands()
        .map(|verb| verb.get_name().to_owned())
        .collect();
    for verb in verbs {
        command = command.mut_subcommand(verb, |verb| {
            with_negative_numbers(verb).after_help(EXIT_STATUSES)
        });
    }
    let compensations = format!("{}\n\n{EXIT_STATUSES}", verb::help::compensations());
    let effects = format!("{}\n\n{EXIT_STATUSES}", verb::help::effects());
    for (verb, lines) in [
        ("run", &compensations),
        ("compare", &compensations),
        ("diagnose", &effects),
    ] {
        command = command.mut_subcommand(verb, |verb| verb.after_long_help(lines.clone()));
    }
    Arguments::from_arg_matches(&command.try_get_matches()?)
}

/// All verbs as typed, `run`, `board calibrate`: those of one level before those of the next.
fn verbs_below(command: &clap::Command) -> Vec<String> {
    let own = command
        .get_subcommands()
        .map(|verb| verb.get_name().to_owned());
    let below = command.get_subcommands().flat_map(|verb| {
        let within = verbs_below(verb).into_iter();
        within.map(|name| format!("{} {name}", verb.get_name()))
    });
    own.chain(below).collect()
}

/// A negative number is a value, refused by name, and not an unknown option; applies to all levels below.
fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let below: Vec<String> = command
        .get_subcommands()
        .map(|verb| verb.get_name().to_owned())
        .collect();
    below
        .into_iter()
        .fold(command.allow_negative_numbers(true), |command, verb| {
            command.mut_subcommand(verb, with_negative_numbers)
        })
}

/// Does what the command line requests. A program with methods of its own calls this after registering them.
pub fn main() -> ExitCode {
    // A reader that stops early, such as `head`, ends the program without an error.
    sigpipe::reset();
    let arguments = match arguments() {
        Ok(arguments) => arguments,
        Err(said) => {
            let verbs = verbs_below(&Arguments::command());
            if let Some(sentence) = terminal::argument_error::sentence(&said, &verbs) {
                return ended(Err(Failure::input(sentence)));
            }
            return match said.print() {
                Ok(()) => ExitCode::from(said.exit_code() as u8),
                Err(e) => ended(Err(Failure::input(format!(
                    "standard output cannot be written: {}",
                    experiment::files::plain::reason(&e)
                )))),
            };
        }
    };
    if arguments.quiet {
        terminal::output::set_quiet();
    }
    if arguments.force {
        experiment::files::look_ahead::set_force();
    }
    let outcome = match arguments.verb {
        Verb::Demo(v) => v.run(),
        Verb::Run(v) => v.run(),
        Verb::Replay(v) => v.run(),
        Verb::Diff(v) => v.run(),
        Verb::Compare(v) => v.run(),
        Verb::Check(v) => v.run(),
        Verb::MonteCarlo(v) => v.run(),
        Verb::Sweep(v) => v.run(),
        Verb::Diagnose(v) => v.run(),
        Verb::Improve(v) => v.run(),
        Verb::Benchmark(v) => v.run(),
        Verb::Serve(v) => v.run(),
        Verb::Identify(v) => v.run(),
        Verb::Effects(v) => v.run(),
        Verb::New(v) => v.run(),
        Verb::Keys(v) => v.run(),
        Verb::Schema(v) => v.run(),
        Verb::Board(v) => v.run(),
        Verb::Completions(v) => v.run(Arguments::command()),
        Verb::Man(v) => v.run(Arguments::command()),
    };
    ended(outcome.and_then(|()| terminal::output::finish()))
}

/// The exit status; prints the failure's sentence.
fn ended(outcome: Result<(), Failure>) -> ExitCode {
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            terminal::output::print_note(format_args!("outerloop: {failure}"));
            failure.exit()
        }
    }
}
