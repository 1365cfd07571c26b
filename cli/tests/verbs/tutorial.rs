//! The tutorial's commands, run as they are, print the figures on the page: all of them without third-party data, and
//! those on the published record if it is available.

use crate::common::root;
use crate::documents::blocks;
use std::path::Path;
use std::process::Command;

/// A command and its printed lines on the page.
struct Step<'a> {
    command: &'a str,
    printed: Vec<&'a str>,
    status: i32,
}

impl Step<'_> {
    /// True if it reads third-party data.
    fn is_on_data(&self) -> bool {
        self.command.contains("$DATA")
    }
}

/// The blocks marked `console`: a command after `$ `, its output below; `...` stands for omitted lines.
fn steps(page: &str) -> Vec<Step<'_>> {
    let mut steps: Vec<Step<'_>> = Vec::new();
    for line in blocks(page, "console").into_iter().flatten() {
        match (line.strip_prefix("$ "), steps.last_mut()) {
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
        }
    }
    steps
}

/// Writes the files on the page: blocks marked `toml` whose first line is a comment with a name.
fn write_files(page: &str, folder: &Path) {
    for block in blocks(page, "toml") {
        let name = block[0].strip_prefix("# ").expect("the name of the file");
        std::fs::write(folder.join(name), block.join("\n")).unwrap();
    }
}

/// Words of a line; their spacing depends on the terminal.
fn words(line: &str) -> Vec<&str> {
    line.split_whitespace().collect()
}

/// The exit status of a step and its output.
fn outcome(step: &Step<'_>, folder: &Path, data: &Path) -> (Option<i32>, String) {
    let arguments = step
        .command
        .strip_prefix("outerloop ")
        .unwrap_or_else(|| panic!("`{}` is no command of outerloop", step.command))
        .split_whitespace()
        .map(|word| word.replace("$DATA", data.to_str().unwrap()));
    let output = Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap();
    let text = [output.stdout, output.stderr].concat();
    (output.status.code(), String::from_utf8(text).unwrap())
}

#[track_caller]
fn run(step: &Step<'_>, folder: &Path, data: &Path) {
    let (status, text) = outcome(step, folder, data);
    assert_eq!(status, Some(step.status), "{}: {text}", step.command);
    let mut lines = text.lines();
    for expected in step.printed.iter().filter(|l| words(l) != ["..."]) {
        assert!(
            lines.any(|line| words(line) == words(expected)),
            "{}\nprints no longer\n{expected}\nbut\n{text}",
            step.command
        );
    }
}

fn page() -> String {
    std::fs::read_to_string(root().join("docs/my-rig-in-an-afternoon.md")).unwrap()
}

#[test]
fn an_afternoon_goes_as_it_is_told_without_any_data() {
    let page = page();
    let steps = steps(&page);
    assert!(steps.len() >= 12, "{}", steps.len());
    assert!(steps.iter().filter(|s| !s.printed.is_empty()).count() >= 10);
    let folder = tempfile::tempdir().unwrap();
    let nothing = folder.path().join("nothing");
    write_files(&page, folder.path());
    for step in &steps {
        if step.is_on_data() {
            let (status, text) = outcome(step, folder.path(), &nothing);
            assert_eq!(status, Some(2), "{}: {text}", step.command);
            assert!(text.trim().lines().count() == 1, "{text}");
            for word in ["https://", "docs/data.md"] {
                assert!(text.contains(word), "{text}");
            }
        } else {
            run(step, folder.path(), &nothing);
        }
    }
}

#[test]
fn the_same_on_the_published_record() {
    let page = page();
    let Some((_, page)) = page.split_once("## The same on a published record") else {
        panic!("the section is called otherwise");
    };
    let steps = steps(page);
    assert!(steps.iter().filter(|s| s.is_on_data()).count() >= 3);
    let (Some(chirp), Some(_)) = (
        test_data::file("measured/utfsm_chirp_0A.csv"),
        test_data::file("ground-motion/RSN1106_KOBE_KJM000.AT2"),
    ) else {
        return;
    };
    let data = std::path::absolute(chirp.parent().unwrap().parent().unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for step in &steps {
        run(step, folder.path(), &data);
    }
}

/// The table of the two rams shows figures that the commands above and below it print.
#[test]
fn the_figures_beside_each_other_are_those_that_are_printed() {
    let page = page();
    let (before, after) = page
        .split_once("## The same on a published record")
        .expect("the section");
    let all = |page: &str| {
        steps(page)
            .iter()
            .flat_map(|s| s.printed.clone())
            .fold(String::new(), |a, l| a + l + "\n")
    };
    let (ours, published) = (all(before), all(after));
    let rows: Vec<Vec<&str>> = after
        .lines()
        .filter(|line| {
            line.starts_with("| ") && line.contains(char::is_numeric) && !line.contains("steps")
        })
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() >= 5, "{rows:?}");
    for row in rows {
        assert!(ours.contains(row[2]), "{row:?}");
        assert!(published.contains(row[3]), "{row:?}");
    }
}
