//! The tutorial's commands, run as they are, print the figures on the page: all of them without third-party data, and
//! those on the published record if it is available.

use crate::common::root;
use crate::documents::blocks;
use std::f64::consts::TAU;
use std::fmt::Write as _;
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

/// A chirp from 0.2 to 8 Hz in 60 s of a ram that is 6.3 ms late and lags by 18.7 ms, in the published file's columns.
fn drawn_chirp() -> String {
    let mut text = String::from("time_s,command_mm,displacement_mm,force_n\n");
    let size = |t: f64| if (0.0..60.0).contains(&t) { 8.0 } else { 0.0 };
    let command = |t: f64| size(t) * (TAU * (0.2 * t + 0.065 * t * t)).sin();
    let (mut moved, mut state) = (0.0, 1_u64);
    for i in 0..61_000 {
        let t = f64::from(i) * 1e-3;
        for k in 0..8 {
            moved += 1.25e-4 / 18.7e-3 * (command(t + f64::from(k) * 1.25e-4 - 6.3e-3) - moved);
        }
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let noise = 0.02 * ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5);
        let t = t + 1e-3;
        let _ = writeln!(text, "{t:.3},{:.5},{:.5},0", command(t), moved + noise);
    }
    text
}

/// The decaying noise of the benchmark's tests as a file of PEER's.
fn drawn_at2(folder: &Path) -> String {
    let csv = std::fs::read_to_string(crate::benchmark_rths::earthquake(folder)).unwrap();
    let points: Vec<&str> = csv
        .lines()
        .skip(1)
        .map(|l| l.split_once(',').unwrap().1)
        .collect();
    let head =
        "PEER NGA STRONG MOTION DATABASE RECORD\ndrawn\nACCELERATION TIME SERIES IN UNITS OF G\n";
    let rows: Vec<String> = points.chunks(5).map(|row| row.join("  ")).collect();
    format!(
        "{head}NPTS= {}, DT= .0200 SEC\n{}\n",
        points.len(),
        rows.join("\n")
    )
}

/// The published section's commands on a chirp and an earthquake drawn here: what it shows holds without its files.
#[test]
fn the_same_on_a_drawn_record() {
    let page = page();
    let (_, page) = page
        .split_once("## The same on a published record")
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    let [measured, motions] = ["measured", "ground-motion"].map(|name| data.join(name));
    for own in [&measured, &motions] {
        std::fs::create_dir_all(own).unwrap();
    }
    std::fs::write(measured.join("utfsm_chirp_0A.csv"), drawn_chirp()).unwrap();
    let at2 = drawn_at2(folder.path());
    std::fs::write(motions.join("RSN1106_KOBE_KJM000.AT2"), at2).unwrap();
    let told: Vec<String> = steps(page)
        .iter()
        .map(|step| {
            let (status, text) = outcome(step, folder.path(), &data);
            // The example's method may be called wrong.
            assert!(matches!(status, Some(0 | 1)), "{}: {text}", step.command);
            println!("{text}");
            text
        })
        .collect();
    let [_, identified, after, before] = &told[..] else {
        panic!("{} commands", told.len());
    };
    let number = |text: &str, before: &str| -> f64 {
        let found = text.split_once(before).map(|(_, rest)| rest);
        let word = found.and_then(|rest| rest.split_whitespace().next());
        word.and_then(|w| w.parse().ok())
            .unwrap_or_else(|| panic!("{before}: {text}"))
    };
    for (name, drawn, within) in [
        ("gain", 1.0, 0.002),
        ("delay", 6.3, 0.2),
        ("lag", 18.7, 0.2),
    ] {
        let value = number(identified, name);
        assert!((value - drawn).abs() < within, "{identified}");
    }
    assert!(number(identified, "The model leaves") < 1.0, "{identified}");
    let error = |text: &str| {
        let (rest, _) = text
            .split_once(" % rms")
            .unwrap_or_else(|| panic!("{text}"));
        rest.split_whitespace()
            .last()
            .unwrap()
            .parse::<f64>()
            .unwrap()
    };
    let [after, before] = [after, before].map(|text| error(text));
    assert!(after < 0.1 && before > 50.0 * after, "{before} {after}");
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
