//! The tutorial's commands, run as they stand, print the figures that it shows.

use crate::common::root;
use std::path::Path;
use std::process::Command;

/// A command and the lines that it is shown to print.
struct Step<'a> {
    command: &'a str,
    printed: Vec<&'a str>,
    status: i32,
}

/// The blocks marked `console`: a command behind `$ `, what it prints below; `...` stands for lines left out.
fn steps(page: &str) -> Vec<Step<'_>> {
    let mut steps: Vec<Step<'_>> = Vec::new();
    let mut inside = false;
    for line in page.lines() {
        match line {
            "```console" => inside = true,
            "```" => inside = false,
            _ if !inside => {}
            line => match (line.strip_prefix("$ "), steps.last_mut()) {
                (Some(command), _) => steps.push(Step {
                    command,
                    printed: Vec::new(),
                    status: 0,
                }),
                (None, Some(step)) => match line.strip_prefix("[exit status ") {
                    Some(status) => step.status = status.trim_end_matches(']').parse().unwrap(),
                    None => step.printed.push(line),
                },
                (None, None) => panic!("`{line}` has no command above it"),
            },
        }
    }
    steps
}

/// Words of a line; how far they stand apart depends on the terminal.
fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

#[track_caller]
fn run(step: &Step<'_>, folder: &Path, data: &Path) {
    let arguments: Vec<String> = step
        .command
        .strip_prefix("outerloop ")
        .unwrap_or_else(|| panic!("`{}` is no command of outerloop", step.command))
        .split_whitespace()
        .map(|word| word.replace("$DATA", data.to_str().unwrap()))
        .collect();
    let output = Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    let text = String::from_utf8(text).unwrap();
    assert_eq!(
        output.status.code(),
        Some(step.status),
        "{}: {text}",
        step.command
    );
    let mut lines = text.lines();
    for expected in step.printed.iter().filter(|l| words(l) != ["..."]) {
        assert!(
            lines.any(|line| words(line) == words(expected)),
            "{}\nprints no longer\n{expected}\nbut\n{text}",
            step.command
        );
    }
}

#[test]
fn an_afternoon_goes_as_it_is_told() {
    let page = std::fs::read_to_string(root().join("docs/my-rig-in-an-afternoon.md")).unwrap();
    let steps = steps(&page);
    assert!(steps.len() >= 6, "{}", steps.len());
    assert!(steps.iter().filter(|s| !s.printed.is_empty()).count() >= 5);
    let Some(chirp) = test_data::file("measured/utfsm_chirp_0A.csv") else {
        return;
    };
    let data = std::path::absolute(chirp.parent().unwrap().parent().unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for step in &steps {
        run(step, folder.path(), &data);
    }
}
