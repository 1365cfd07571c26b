//! Rigs as other laboratories record them, and what the diagnosis says about them, by cause.
//!
//! ```text
//! cargo run --release -p exam --example field -- [A..B | SEED]... [--devices | --rams | --worlds] [--only WORD] [--list] [--evidence | --noise | --hidden | --third | --settle=N]
//! ```
//!
//! - `--devices`: specimens of earthquake laboratories instead (bearings, dampers, braces, walls).
//! - `--rams`: rams under position control, every second one sound; prints by how much the aims of the field trial are missed.
//! - `--worlds`: each seed three times: as a field rig, as a laboratory specimen and as a ram.
//! - `--evidence`: lists each name that was given for sure, whether it is false, how much of the error its model leaves, and
//!   its `q`.
//! - `--noise`: compares the stated noise of records without a rest with the true noise.
//! - `--hidden`: compares what the best-fitting sound ram leaves of a faulty ram's record with the noise. Less than the noise
//!   cannot be found. With `--only` it needs `--rams`, too.
//! - `--third`: has each specimen play a third motion and compares what the model found leaves of it with the noise.
//! - `--settle=100`: for the first hundred rigs whose first record is ambiguous, plays up to two tests as `--next` designs them,
//!   and up to two by the fixed advice of the notes.
//! - `--only Cut`: takes the rigs with that word in their description (cause, motion, how it was cut).

mod grading;
mod hidden;
mod noise;
mod settle;
mod third;

use exam::aims::{self, Aim, Figure};
use exam::devices::{devices, set_device};
use exam::field::{Field, Mark, SOUND_RAM, causes, faults, set_field, set_ram};
use grading::GradedField;
use indicatif::ProgressBar;
use rayon::prelude::*;

/// Pairs of options of which one would be ignored.
const EXCLUSIVE: [(&str, &str); 13] = [
    ("--devices", "--rams"),
    ("--devices", "--worlds"),
    ("--rams", "--worlds"),
    ("--only", "--worlds"),
    ("--noise", "--worlds"),
    ("--hidden", "--devices"),
    ("--hidden", "--worlds"),
    ("--third", "--devices"),
    ("--third", "--rams"),
    ("--third", "--worlds"),
    ("--settle", "--devices"),
    ("--settle", "--rams"),
    ("--settle", "--worlds"),
];

/// Makes the rig of a seed.
type World = fn(u64) -> Field;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    refuse_exclusive(&arguments);
    let list = arguments.iter().any(|a| a == "--list");
    let in_laboratories = arguments.iter().any(|a| a == "--devices");
    let in_rams = arguments.iter().any(|a| a == "--rams");
    let in_worlds = arguments.iter().any(|a| a == "--worlds");
    let worlds: [(World, Vec<_>); 3] = [
        (set_field, causes().collect()),
        (set_device, devices().collect()),
        (set_ram, faults().collect()),
    ];
    let one = if in_laboratories {
        1
    } else {
        2 * usize::from(in_rams)
    };
    let worlds = if in_worlds {
        &worlds[..]
    } else {
        &worlds[one..=one]
    };
    let mut names: Vec<&str> = Vec::new();
    for name in worlds.iter().flat_map(|w| &w.1) {
        // A cause can appear in two worlds.
        if !names.contains(name) {
            names.push(name);
        }
    }
    let range = |a: &String| -> Option<Vec<u64>> {
        match a.split_once("..") {
            Some((from, to)) => Some((from.parse().ok()?..to.parse().ok()?).collect()),
            None => Some(vec![a.parse().ok()?]),
        }
    };
    let mut seeds: Vec<u64> = arguments.iter().filter_map(range).flatten().collect();
    if seeds.is_empty() {
        seeds = (0..320).collect();
    }
    let set = worlds[0].0;
    let only = arguments.iter().position(|a| a == "--only");
    if let Some(word) = only.and_then(|at| arguments.get(at + 1)) {
        seeds = seeds
            .into_par_iter()
            .filter(|seed| set(*seed).id.contains(word))
            .collect();
    }
    if arguments.iter().any(|a| a == "--noise") {
        noise::all(seeds, set, list);
        return;
    }
    if arguments.iter().any(|a| a == "--hidden") {
        hidden::all(seeds, list);
        return;
    }
    if arguments.iter().any(|a| a == "--third") {
        third::all(seeds, list);
        return;
    }
    let wanted = arguments
        .iter()
        .find_map(|a| a.strip_prefix("--settle=")?.parse().ok());
    if let Some(wanted) = wanted {
        if !settle::all(seeds, wanted, list) {
            eprintln!("field: designed tests settle fewer rigs than aimed at, by more than chance");
            std::process::exit(1);
        }
        return;
    }
    let rigs = worlds
        .iter()
        .flat_map(|w| seeds.iter().map(|seed| (w.0, *seed)));
    let rigs: Vec<(World, u64)> = rigs.collect();
    let bar = ProgressBar::new(rigs.len() as u64);
    let all: Vec<GradedField> = rigs
        .into_par_iter()
        .map(|(set, seed)| grading::answer(set(seed)))
        .inspect(|_| bar.inc(1))
        .inspect(|s| {
            if list && !matches!(s.mark, Mark::Right | Mark::Set) {
                show(s);
            }
        })
        .collect();
    if arguments.iter().any(|a| a == "--evidence") {
        evidence(&all);
    }
    by_cause(&names, &all);
    calibration(&all);
    reliability(&all);
    let mut aimed: Vec<(&[Aim], &[Figure])> = Vec::new();
    let trial = field_trial(&all);
    if in_rams {
        aimed.push((&aims::FIELD_TRIAL, &trial));
    }
    let seconds = aims::seconds(all.iter().map(|s| s.seconds));
    aimed.push((&aims::SECONDS, &seconds));
    println!("\n{} rigs\n\n{}", all.len(), aims::table(&aimed));
}

/// Refuses options of which one would be ignored.
fn refuse_exclusive(arguments: &[String]) {
    let given = |option: &str| {
        arguments
            .iter()
            .any(|a| a.split('=').next() == Some(option))
    };
    for (one, other) in EXCLUSIVE {
        assert!(
            !(given(one) && given(other)),
            "{one} and {other} exclude each other: leave out one of them"
        );
    }
}

/// How rams did by the field trial's measures: sound ones called sound, faults found, faults named wrongly.
fn field_trial(all: &[GradedField]) -> [Figure; 3] {
    let (sound, faulty): (Vec<&GradedField>, Vec<&GradedField>) =
        all.iter().partition(|s| s.cause == SOUND_RAM);
    let share = |of: &[&GradedField], marks: &[Mark]| {
        let part = of.iter().filter(|s| marks.contains(&s.mark)).count();
        Figure::share(part as f64, of.len())
    };
    [
        share(&sound, &[Mark::Right]),
        share(&faulty, &[Mark::Right, Mark::Set]),
        share(&faulty, &[Mark::Wrong, Mark::WrongSet, Mark::Overclaimed]),
    ]
}

fn show(s: &GradedField) {
    println!(
        "{:?} [{}] {} {:?} or {:?}, q {:?}; {:.4} -> {:.4} of {:.4}; {} samples, {:.1} s",
        s.mark,
        s.id,
        s.said.verdict,
        s.said.names,
        s.said.others,
        s.said.q,
        s.errors[0],
        s.errors[1],
        s.errors[2],
        s.samples,
        s.seconds
    );
    for note in &s.notes {
        println!("    {note}");
    }
}

fn by_cause(names: &[&str], all: &[GradedField]) {
    let heads = Mark::ALL.map(|m| format!("{m:?}").to_lowercase());
    println!("| cause | rigs | {} |", heads.join(" | "));
    println!("|---|---|{}", "---|".repeat(heads.len()));
    let row = |name: &str, of: &[&GradedField]| {
        let count = |m: Mark| of.iter().filter(|s| s.mark == m).count();
        let cells = Mark::ALL.map(|m| {
            count(m)
                .to_string()
                .replace('0', if count(m) == 0 { "" } else { "0" })
        });
        println!("| {name} | {} | {} |", of.len(), cells.join(" | "));
    };
    for cause in names {
        row(
            cause,
            &all.iter().filter(|s| s.cause == *cause).collect::<Vec<_>>(),
        );
    }
    row("**all**", &all.iter().collect::<Vec<_>>());
}

/// Each name with its `q`, for a new calibration.
fn evidence(all: &[GradedField]) {
    println!("| rig | name | channel | false | error left | q |");
    println!("|---|---|---|---|---|---|");
    for s in all {
        for v in &s.vouched {
            println!("| {} | {} |", s.id, v.row());
        }
    }
}

/// How often names are in the rig, by their stated probability, whether in a set, beside others or for sure; of rigs of which
/// at most one name is right.
fn reliability(all: &[GradedField]) {
    let sure = |s: &GradedField| {
        s.vouched
            .iter()
            .map(|v| (1.0 - v.q, !v.is_false))
            .collect::<Vec<_>>()
    };
    let stated: Vec<(f64, bool)> = all
        .iter()
        .filter(|s| s.one_name)
        .flat_map(|s| [sure(s), s.open.clone()].concat())
        .collect();
    println!("\n{}", exam::reliability::table(&stated));
}

/// The share of false names among those given with a `q` up to a level.
fn calibration(all: &[GradedField]) {
    let vouched: Vec<_> = all.iter().flat_map(|s| &s.vouched).collect();
    let drives = vouched.iter().filter(|v| v.actuator);
    let (names, wrong) = drives.fold((0, 0), |(n, w), v| (n + 1, w + u32::from(v.is_false)));
    println!("of these of actuators: {wrong} of {names} false\n");
    println!("| q at most | names | false | share |\n|---|---|---|---|");
    for level in [0.02, 0.05, 0.1] {
        let of: Vec<bool> = vouched
            .iter()
            .filter(|v| v.q <= level)
            .map(|v| v.is_false)
            .collect();
        let wrong = of.iter().filter(|w| **w).count();
        let share = wrong as f64 / of.len().max(1) as f64;
        println!("| {level} | {} | {wrong} | {share:.3} |", of.len());
    }
}
