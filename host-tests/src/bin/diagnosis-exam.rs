//! The exam of the diagnosis as one table.
//!
//! ```text
//! cargo run --release -p host-tests --bin diagnosis-exam -- [--sealed | --seeds A..B] [--records N] [--class NAME] [--hides EFFECT] \
//!     [--quick] [--list] [--json FILE]
//! cargo run --release -p host-tests --bin diagnosis-exam -- --export DIR     # the questions as files, without key
//! cargo run --release -p host-tests --bin diagnosis-exam -- --answers FILE   # grades somebody else's answers
//! ```

use clap::Parser;
use exam::Class;
use host_tests::exam::plan::{Item, SEALED, TUNING};
use host_tests::exam::run::{GradedRecord, run_exam};
use host_tests::exam::tally::said;
use host_tests::exam::{Answer, Mark, Plan, Report, examinee, export};
use indicatif::{ProgressBar, ProgressStyle};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Parser)]
#[command(about = "Set the diagnosis its exam and print the result")]
struct Arguments {
    /// Seeds A..B, without B; every class starts at A. Left out: the tuning range
    #[arg(long, value_parser = range, conflicts_with = "sealed")]
    seeds: Option<Range<u64>>,
    /// The seeds that are never looked at in development, for reported figures
    #[arg(long)]
    sealed: bool,
    /// At most this many records of each class
    #[arg(long)]
    records: Option<u64>,
    /// A quick exam: every effect once by each set of equations
    #[arg(long)]
    quick: bool,
    /// Only records of this class
    #[arg(long, value_parser = class)]
    class: Option<Class>,
    /// Only records that hide this effect
    #[arg(long, value_parser = effect)]
    hides: Option<String>,
    /// List every record whose answer was not exact
    #[arg(long)]
    list: bool,
    /// Also write all figures and marks into this file
    #[arg(long)]
    json: Option<PathBuf>,
    /// Only write the questions into this folder
    #[arg(long)]
    export: Option<PathBuf>,
    /// Grade the answers in this file: one JSON object per line, `{"record": "unseen-12", "answer": {...}}`
    #[arg(long)]
    answers: Option<PathBuf>,
}

fn range(text: &str) -> Result<Range<u64>, String> {
    let refused =
        || format!("`{text}` is not a range of seeds; A..B with A below B is, as in 0..40");
    let (a, b) = text.split_once("..").ok_or_else(refused)?;
    let number = |s: &str| s.trim().parse::<u64>().map_err(|_| refused());
    let range = number(a)?..number(b)?;
    if range.is_empty() {
        return Err(refused());
    }
    Ok(range)
}

fn class(text: &str) -> Result<Class, String> {
    let known = Class::ALL.map(Class::name).join(", ");
    Class::ALL
        .into_iter()
        .find(|c| c.name() == text)
        .ok_or_else(|| format!("`{text}` is no class; accepted are {known}"))
}

fn effect(text: &str) -> Result<String, String> {
    let known = exam::effect::family(text).map(|_| text.to_owned());
    known
        .ok_or_else(|| format!("`{text}` is no effect of the exam; `outerloop effects` lists them"))
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(sentence) => {
            eprintln!("{sentence}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let seeds = match (&arguments.seeds, arguments.sealed) {
        (Some(seeds), _) => seeds.clone(),
        (None, true) => SEALED,
        (None, false) => TUNING,
    };
    let mut plan = if arguments.quick {
        Plan::quick(seeds)
    } else {
        Plan::full(seeds)
    };
    if let Some(records) = arguments.records {
        plan = plan.at_most(records);
    }
    if let Some(class) = arguments.class {
        plan.items.retain(|i| i.class == class);
    }
    if let Some(name) = &arguments.hides {
        let hidden = |i: &Item| exam::hides(i.class, i.seed).contains(&name.as_str());
        plan.items.retain(hidden);
    }
    if let Some(folder) = &arguments.export {
        let written =
            export::export(folder, &plan.items).map_err(|e| format!("{folder:?}: {e}"))?;
        println!("{written} questions in {}", folder.display());
        return Ok(());
    }
    let all = match &arguments.answers {
        Some(file) => {
            let answers = read(file)?;
            plan.items = answers
                .keys()
                .map(|id| Item::from_id(id))
                .collect::<Result<_, _>>()?;
            work(&plan, arguments.list, |item, _| {
                let id = format!("{}-{}", item.class.name(), item.seed);
                answers[&id].clone()
            })
        }
        None => work(&plan, arguments.list, |_, paper| examinee::diagnosis(paper)),
    }?;
    show(&plan, &all, arguments.json.as_deref())
}

type Answers = BTreeMap<String, Result<Answer, String>>;

fn read(file: &Path) -> Result<Answers, String> {
    let text = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let mut answers = Answers::new();
    for (i, line) in text
        .lines()
        .enumerate()
        .filter(|(_, l)| !l.trim().is_empty())
    {
        let at = |e: String| format!("{}, line {}: {e}", file.display(), i + 1);
        let value: serde_json::Value = serde_json::from_str(line).map_err(|e| at(e.to_string()))?;
        let id = value["record"]
            .as_str()
            .ok_or_else(|| at("no `record`".into()))?;
        let answer = serde_json::from_value(value["answer"].clone()).map_err(|e| e.to_string());
        answers.insert(id.into(), answer);
    }
    Ok(answers)
}

fn work(
    plan: &Plan,
    list: bool,
    examinee: impl Fn(&Item, &exam::Paper) -> Result<Answer, String> + Sync,
) -> Result<Vec<GradedRecord>, String> {
    let bar = ProgressBar::new(plan.items.len() as u64);
    if let Ok(style) = ProgressStyle::with_template("{wide_bar} {pos}/{len} records, {eta} to go") {
        bar.set_style(style);
    }
    let all = run_exam(&plan.items, examinee, |graded| {
        bar.inc(1);
        if let Some(text) = line(graded).filter(|_| list) {
            bar.suspend(|| println!("{text}"));
        }
    });
    bar.finish_and_clear();
    all
}

/// A line about a record whose answer was not exact.
fn line(s: &GradedRecord) -> Option<String> {
    if s.grade.mark == Mark::Exact {
        return None;
    }
    let hidden: Vec<String> = s
        .key
        .channels
        .iter()
        .flat_map(|k| {
            let listed = k.hidden.iter().map(|h| {
                format!(
                    "{} {} ({}) {:.0} sigma",
                    k.channel.name(),
                    h.name,
                    h.equation,
                    h.size
                )
            });
            listed
                .chain(k.outside.map(|o| format!("{} {o}", k.channel.name())))
                .collect::<Vec<_>>()
        })
        .collect();
    Some(format!(
        "{}-{} {:?} [{}] {:?} -> {} ({:.1} s)",
        s.item.class.name(),
        s.item.seed,
        s.grade.mark,
        hidden.join(" + "),
        s.key.excitation,
        said(s),
        s.seconds
    ))
}

fn show(plan: &Plan, all: &[GradedRecord], json: Option<&Path>) -> Result<(), String> {
    let report = Report::new(all);
    println!(
        "{} records, seeds {}..{} ({})",
        all.len(),
        plan.seeds.start,
        plan.seeds.end,
        plan.kind()
    );
    println!("\n{}", report.target_table());
    println!("\n{}", report.aim_table());
    println!("\n{}", report.mark_table());
    for class in [
        Class::Matched,
        Class::Unseen,
        Class::Outside,
        Class::Confounded,
    ] {
        println!("\n{}:\n{}", class.name(), report.confusion_table(class));
    }
    println!("\n{}", report.reliability_table());
    if !report.detection.is_empty() {
        println!("\ndetection limit:\n{}", report.detection_table());
    }
    if let Some(file) = json {
        std::fs::write(file, format!("{:#}", report.to_json()))
            .map_err(|e| format!("{}: {e}", file.display()))?;
    }
    Ok(())
}
