//! Every verb on a terminal of 80 columns.
#![cfg(unix)]

use crate::common::command;
use crate::common::narrow::{self, check, seen};
use std::collections::BTreeSet;
use std::path::Path;

/// Verbs that print no table: scripts for a shell and for `man`; questions; what tests with a board or a client check
/// (the width of `board desk` and `board commission` is checked there).
const WITHOUT_TABLE: [&str; 7] = [
    "completions",
    "man",
    "new",
    "board",
    "serve",
    "benchmark",
    "help",
];

/// Commands with all tables and sentences that the verbs print; `o` is an empty folder.
const LINES: [&str; 21] = [
    "demo",
    "run examples/table1.toml --out o/first",
    "run examples/table1.toml --compensation tangent --out o/second",
    "run examples/three-storey.toml --duration 8",
    "run examples/coupled-frame.toml --duration 4",
    "replay o/first/record.h5",
    "diff o/first o/second",
    "compare examples/table1.toml --duration 8",
    "compare examples/table1.toml --duration 8 --record o/one.csv --record o/two.csv --compensations none,tangent+ats",
    "compare examples/coupled-frame.toml --duration 4",
    "check examples/table1.toml --plants 4",
    "monte-carlo examples/table1.toml --tests 4",
    "sweep examples/table1.toml --duration 8 --over plant.actuator.delay_ms=2,8 --compensations none,paper,tangent,ats,amb,feedforward-feedback,tangent+ats",
    "sweep examples/table1.toml --over excitation.scale=.5,1 --record o/one.csv --record o/two.csv",
    "diagnose --model o/model.toml --train o/first/record.csv@..20 --test o/first/record.csv@20.. --remainder",
    "improve examples/undeclared/calibration.toml",
    "identify o/first/record.csv",
    "effects",
    "keys",
    "keys plant.actuator",
    "schema",
];

/// The output of a command on a terminal; `o` is the folder.
fn told(folder: &Path, line: &str) -> (Option<i32>, String) {
    let inside = |word: &str| match word.strip_prefix("o/") {
        Some(rest) => folder.join(rest).display().to_string(),
        None => word.to_owned(),
    };
    let words: Vec<String> = line.split(' ').map(inside).collect();
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    narrow::told(command(&words))
}

#[test]
fn every_verb_fits_a_terminal_of_80_columns() {
    let home = tempfile::tempdir().unwrap();
    let folder = home.path();
    let model = "[actuator]\ndelay_ms = { value = 3, tolerance = 0.5 }\n\
                 [specimen]\nstiffness_n_per_mm = { value = 158, tolerance = 2 }\n";
    std::fs::write(folder.join("model.toml"), model).unwrap();
    for (name, hz) in [("one.csv", 2.1), ("two.csv", 1.3)] {
        let row = |i: i32| {
            let t = 0.01 * f64::from(i);
            let a = 0.2 * (hz * std::f64::consts::TAU * t).sin() * (-t / 4.0).exp();
            format!("{t:.2},{a:.5}\n")
        };
        let rows: String = (0..1500).map(row).collect();
        std::fs::write(folder.join(name), format!("time_s,acc_g\n{rows}")).unwrap();
    }
    let mut tried = BTreeSet::new();
    for line in LINES {
        let (status, text) = told(folder, line);
        // A method that runs away is a valid result.
        assert!(matches!(status, Some(0 | 1)), "{line}: {text}");
        assert!(text.lines().count() > 1, "{line}: {text}");
        check(line, &text);
        tried.insert(line.split(' ').next().unwrap());
    }
    let help = seen(&told(folder, "--help").1).join("\n");
    let verbs = help.split("Commands:").nth(1).unwrap();
    let verbs = verbs.split("Options:").next().unwrap();
    let mut known = 0;
    for line in verbs.lines().filter(|line| line.starts_with("  ")) {
        let Some(verb) = line
            .strip_prefix("  ")
            .filter(|line| !line.starts_with(' '))
        else {
            continue;
        };
        let verb = verb.split(' ').next().unwrap();
        assert!(
            tried.contains(verb) || WITHOUT_TABLE.contains(&verb),
            "{verb} is not tried above"
        );
        known += 1;
        if verb != "help" {
            let line = format!("{verb} --help");
            check(&line, &told(folder, &line).1);
        }
    }
    assert!(known > 15, "the help is not read any more: {help}");
}

#[test]
fn both_benchmarks_fit_a_terminal_of_80_columns() {
    let problem = crate::benchmark_marths::drawn_problem();
    for line in [
        "benchmark marths --records ElCentro --controllers none,coupled-fixed,coupled --plants 1",
        "benchmark rths --records ElCentro --controllers none,tangent,feedforward-feedback --plants 1",
    ] {
        let line = format!("{line} --data {}", problem.path().display());
        let (status, text) = told(Path::new(""), &line);
        assert_eq!(status, Some(0), "{text}");
        check(&line, &text);
    }
}

#[test]
fn what_is_read_is_no_wider_than_a_page_where_there_is_no_terminal() {
    for verb in ["keys", "effects"] {
        let text = crate::common::outerloop(&[verb]).stdout;
        let text = String::from_utf8(text).unwrap();
        let widest = text.lines().map(textwrap::core::display_width).max();
        assert!((60..=100).contains(&widest.unwrap()), "{verb}: {widest:?}");
    }
}
