//! Validates the verdicts of `check` and the interlocks of a test over many drawn tests.

use clap::{Parser, Subcommand};
use comfy_table::{Table, presets};
use experiment::failure::Failure;
use experiment::files::output;
use host_tests::data;
use host_tests::surveys::promise::{MonitorPromise, SurveyPromise};
use host_tests::surveys::{coupled, monitor, verdicts, watch, watched_records};
use indicatif::ProgressBar;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Validate `check` and the interlocks over many drawn tests. Exit status 2: bad input
#[derive(Parser, Debug)]
struct Arguments {
    #[command(subcommand)]
    survey: Survey,
    /// Seed of the draw
    #[arg(long, default_value_t = 1, global = true)]
    seed: u64,
    /// One JSON object on standard output and nothing else
    #[arg(long, global = true)]
    json: bool,
}

#[derive(Subcommand, Debug)]
enum Survey {
    /// Compare the verdicts with what the tests then do: exit status 1 if a test was called stable and ran away, or, but for
    /// --as-declared, if more than 5 % of the sound tests, and more than chance allows, were not called stable
    Verdicts {
        /// How many rigs
        #[arg(default_value_t = 1000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        rigs: u64,
        /// Draw rigs with two coupled actuators instead
        #[arg(long)]
        coupled: bool,
        /// Let `check` know the declared actuators only, and run the tests on the true ones
        #[arg(long, requires = "coupled")]
        as_declared: bool,
    },
    /// Run the rig watch on this many sound tests, and on others in which something goes wrong: the table of its targets. Exit
    /// status 1 if one of them is missed by more than docs/rig-watch-validation.md says, and by more than chance
    Watch {
        /// How many sound tests
        #[arg(default_value_t = 3000, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
        sound: u64,
        /// How many tests in which something goes wrong
        #[arg(default_value_t = 1000, value_parser = clap::value_parser!(u64).range(0..=1_000_000))]
        faulty: u64,
        /// Instead, write test file and ground motion of one test of this survey into this folder, and print how to run it
        #[arg(long, value_name = "DIR")]
        write: Option<PathBuf>,
        /// Number of this test in its lot, from 0
        #[arg(long, default_value_t = 0, requires = "write")]
        number: u64,
        /// Lot of this test
        #[arg(long, value_enum, default_value_t = watch::Lot::Sound, requires = "write")]
        lot: watch::Lot,
    },
    /// Compare what the rig watch says of third-party records of actuators with the diagnosis of the same records
    Records,
    /// Try the interlocks on this many sound tests, and on a quarter as many in which something breaks
    Monitor {
        /// How many sound tests
        #[arg(default_value_t = 10_000, value_parser = clap::value_parser!(u64).range(10..=1_000_000))]
        tests: u64,
    },
}

/// A survey as JSON.
#[derive(Serialize)]
struct Answer<'a, P, R, C> {
    seed: u64,
    promise: P,
    rows: &'a [R],
    cases: &'a [C],
}

/// The survey of the rig watch as JSON.
#[derive(Serialize)]
struct WatchAnswer<'a> {
    seed: u64,
    targets: &'a [watch::Target],
    sound: &'a [watch::SoundTrial],
    recorded: &'a [watch::SoundTrial],
    faulty: &'a [watch::FaultTrial],
    of_any_kind: &'a [watch::FaultTrial],
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let held = match arguments.survey {
        Survey::Verdicts {
            rigs,
            coupled,
            as_declared,
        } => {
            let known = match as_declared {
                true => verdicts::Known::AsDeclared,
                false => verdicts::Known::Rig,
            };
            survey((rigs as usize, coupled), known, &arguments)
        }
        Survey::Monitor { tests } => monitor(tests as usize, &arguments),
        Survey::Watch {
            write: Some(ref folder),
            number,
            lot,
            ..
        } => write_test(folder, arguments.seed, (lot, number)),
        Survey::Watch { sound, faulty, .. } => rig_watch([sound, faulty], &arguments),
        Survey::Records => records(&arguments),
    };
    match held {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(failure) => {
            eprintln!("check-surveys: {failure}");
            failure.exit()
        }
    }
}

fn print_json(answer: &impl Serialize) {
    let text = serde_json::to_string_pretty(answer).unwrap_or_else(|e| e.to_string());
    println!("{text}");
}

fn table<const N: usize>(head: [&str; N]) -> Table {
    let mut table = Table::new();
    table.load_preset(presets::ASCII_MARKDOWN).set_header(head);
    table
}

/// The interlocks over many tests; true if no sound test was stopped.
fn monitor(sound: usize, arguments: &Arguments) -> Result<bool, Failure> {
    let plans = monitor::draw(sound, sound / 4, arguments.seed);
    let progress = ProgressBar::new(plans.len() as u64);
    let cases = monitor::run(&plans, || progress.inc(1))?;
    progress.finish_and_clear();
    let rows = monitor::table(&cases);
    let promise = MonitorPromise::of(&rows);
    if arguments.json {
        print_json(&Answer {
            seed: arguments.seed,
            promise,
            rows: &rows,
            cases: &cases,
        });
        return Ok(promise.sound_stopped == 0);
    }
    let [energy, hsem, displacement, tracking, reading] = monitor::INDICATORS;
    let mut t = table([
        "tests",
        "",
        "not counted",
        energy,
        displacement,
        tracking,
        reading,
        "any of the four",
        hsem,
    ]);
    for r in &rows {
        let [energy, hsem, displacement, tracking, reading] = r.stopped.map(|n| n.to_string());
        t.add_row([
            r.kind.name().to_owned(),
            r.count.to_string(),
            r.others.to_string(),
            energy,
            displacement,
            tracking,
            reading,
            r.together.to_string(),
            hsem,
        ]);
    }
    println!("{t}");
    let [energy, hsem, displacement, tracking, reading] =
        rows.first().map_or([0.0; 5], |r| r.largest);
    println!(
        "Stopped at an energy error of {} of the energy in the test, or where {} of the planned peak are sent or {:.3} of it \
         are read, or at {} of the planned tracking; broken tests before {} of the peak.\nSound tests came to {energy:.3} by \
         core's indicator, {hsem:.3} by the published one, {displacement:.3} of the planned peak sent and {reading:.3} of it \
         read, {tracking:.3} of the planned tracking.",
        monitor::ENERGY_TRIP,
        monitor::DISPLACEMENT,
        monitor::thresholds()[4],
        monitor::TRACKING,
        monitor::TOO_FAR,
    );
    println!("{}", promise.sentence());
    Ok(promise.sound_stopped == 0)
}

/// The rig watch over many tests; true if it is as good as docs/rig-watch-validation.md says.
fn rig_watch([sound, faulty]: [u64; 2], arguments: &Arguments) -> Result<bool, Failure> {
    // Half as many more have an effect of any kind, from the start or from mid-test.
    let others = faulty / 2;
    // A tenth as many more sound ones have a recorded ground motion.
    let under_records = sound / 10;
    let progress = ProgressBar::new(sound + under_records + faulty + others);
    let motions = data::recorded();
    let recorded = watch::recorded(under_records, arguments.seed, &motions, || progress.inc(1))?;
    let sound = watch::sound(sound, arguments.seed, || progress.inc(1))?;
    let faulty = watch::faulty(faulty, arguments.seed, || progress.inc(1))?;
    let of_any_kind = watch::of_any_kind(others, arguments.seed, || progress.inc(1))?;
    progress.finish_and_clear();
    let targets = watch::targets([&sound, &recorded], &faulty, &of_any_kind);
    let worse: Vec<&str> = targets
        .iter()
        .filter(|t| !t.holds)
        .map(|t| t.target)
        .collect();
    if arguments.json {
        print_json(&WatchAnswer {
            seed: arguments.seed,
            targets: &targets,
            sound: &sound,
            recorded: &recorded,
            faulty: &faulty,
            of_any_kind: &of_any_kind,
        });
        return Ok(worse.is_empty());
    }
    let mut t = table(["target", "aim", "found", "missed by"]);
    for r in &targets {
        t.add_row([r.target, r.aim, &r.found, &r.missed]);
    }
    println!("{t}\n");
    let from_mid_test = watch::by_effect(&watch::Kind::ALL, &faulty);
    print_effects("effect from mid-test", from_mid_test);
    let others = watch::by_effect(&watch::Kind::OTHERS, &of_any_kind);
    print_effects("from the start or in mid-test", others);
    println!("false names:");
    for (lot, trials) in [("sound", &sound), ("recorded", &recorded)] {
        for (i, trial) in trials.iter().enumerate().filter(|(_, t)| t.counts) {
            if let Some(named) = &trial.named {
                println!("  --lot {lot} --number {i}, {}: {named}", trial.kind);
            }
        }
    }
    println!("made worse by a correction:");
    let is_worse =
        |(_, t): &(usize, &watch::FaultTrial)| t.counts && (t.is_made_worse() || t.unstable);
    for (lot, trials) in [("mid-test", &faulty), ("any-kind", &of_any_kind)] {
        for (i, trial) in trials.iter().enumerate().filter(is_worse) {
            let [_, with, corrected] = trial.eps.map(|e| 100.0 * e);
            let (rig, kind) = (&trial.rig, trial.kind.name());
            println!(
                "  --lot {lot} --number {i}, {rig}, {kind}: eps {with:.1} to {corrected:.1} %"
            );
        }
    }
    if !worse.is_empty() {
        println!(
            "\nworse than in docs/rig-watch-validation.md, by more than chance: {}",
            worse.join("; ")
        );
    }
    Ok(worse.is_empty())
}

fn print_effects(head: &str, rows: Vec<[String; 9]>) {
    let mut t = table([
        head,
        "tests",
        "named",
        "first right",
        "settled right",
        "one name",
        "eps % without",
        "with",
        "corrected",
    ]);
    for row in rows {
        t.add_row(row);
    }
    println!("{t}\n");
}

/// Writes test file and ground motion of one test of the survey with this seed.
fn write_test(folder: &Path, seed: u64, (lot, i): (watch::Lot, u64)) -> Result<bool, Failure> {
    let test = lot.test(seed, i);
    let (text, shaking) =
        test.ok_or_else(|| Failure::input("no recorded ground motion is at hand"))?;
    let points = shaking.acc_m_per_s2.iter().enumerate();
    let motion: String = points
        .map(|(i, a)| format!("{:.5},{a}\n", i as f64 * shaking.interval_s))
        .collect();
    let motion = format!("time_s,acc_m_per_s2\n{motion}");
    output::write_all(folder, &[("test.toml", text), ("motion.csv", motion)])?;
    let [test, motion] = ["test.toml", "motion.csv"].map(|name| folder.join(name));
    println!(
        "outerloop run {} --record {} --seed {}",
        test.display(),
        motion.display(),
        lot.seed(seed, i)
    );
    Ok(true)
}

/// The rig watch over third-party records; true if at most one name is false.
fn records(arguments: &Arguments) -> Result<bool, Failure> {
    let rows = watched_records::all()?;
    let wrong = rows.iter().filter(|r| r.is_false).count();
    if arguments.json {
        print_json(&rows);
        return Ok(wrong <= 1);
    }
    let mut t = table([
        "record",
        "what is known",
        "the watch",
        "the diagnosis",
        "agree",
        "false",
    ]);
    for r in &rows {
        let yes = |b: bool| if b { "yes" } else { "no" };
        let agree = r.agrees.map_or("-", yes);
        t.add_row([
            &r.id,
            &r.known,
            &r.watch,
            &r.diagnosis,
            agree,
            yes(r.is_false),
        ]);
    }
    println!(
        "{t}\n{wrong} false names in {} records (aim: at most 1).",
        rows.len()
    );
    Ok(wrong <= 1)
}

/// The verdicts over many rigs; true if they are as good as is required of them.
fn survey(
    (rigs, of_coupled): (usize, bool),
    known: verdicts::Known,
    arguments: &Arguments,
) -> Result<bool, Failure> {
    let tests = if of_coupled {
        coupled::draw(rigs, arguments.seed)
    } else {
        verdicts::draw(rigs, arguments.seed)
    };
    let progress = ProgressBar::new(rigs as u64);
    let cases = verdicts::run(&tests, known, || progress.inc(1))?;
    progress.finish_and_clear();
    let rows = verdicts::table(&cases);
    let promise = SurveyPromise::of(&rows);
    if arguments.json {
        print_json(&Answer {
            seed: arguments.seed,
            promise,
            rows: &rows,
            cases: &cases,
        });
    } else {
        let mut t = table(["tests", "which", "", "stable", "doubtful", "unstable"]);
        for r in rows.iter().filter(|r| r.count > 0) {
            let [stable, doubtful, unstable] = r.called.map(|n| n.to_string());
            t.add_row([
                r.tests.clone(),
                r.truth.words().to_owned(),
                r.count.to_string(),
                stable,
                doubtful,
                unstable,
            ]);
        }
        println!("{t}");
        println!("{}", promise.sentence());
    }
    Ok(promise.is_kept(known))
}
