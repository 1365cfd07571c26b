//! No output replaces an input, whatever the verb, the option and the spelling of the path; no record that cannot be made
//! again is replaced.

use crate::common::{command, outerloop};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Output;

/// Options and arguments that only read a file or a folder.
const READ: [&str; 14] = [
    "--record",
    "--signal",
    "--model",
    "--train",
    "--test",
    "--rest",
    "--data",
    "--follow",
    "--file",
    "--port",
    "--witness",
    "<TEST>",
    "<ARCHIVE>",
    "<FIRST>",
];

/// Every place that a verb writes to, with a command in which it is also an input.
const WRITTEN: [(&str, &str, &str); 21] = [
    ("run", "--out", "run o/record.csv --out o"),
    ("run", "--archive", "run table1.toml --archive table1.toml"),
    ("compare", "--out", "compare o/compare.json --out o"),
    ("check", "--out", "check o/check.json --out o"),
    (
        "sweep",
        "--out",
        "sweep o/sweep.csv --over excitation.scale=1,2 --out o",
    ),
    (
        "monte-carlo",
        "--out",
        "monte-carlo o/tests.csv --tests 2 --out o",
    ),
    ("replay", "--out", "replay o/replay.json --out o"),
    (
        "diff",
        "--out",
        "diff o/report.html o/difference.json --out o",
    ),
    (
        "improve",
        "--out",
        "improve o/table1-record.csv table1.toml --out o",
    ),
    ("serve", "--out", "serve o/summary.json --out o --once"),
    (
        "diagnose",
        "--out",
        "diagnose --model o/model.toml --train m.csv@0..5 --test m.csv@5..9 --out o",
    ),
    (
        "diagnose",
        "--save-model",
        "diagnose --model model.toml --train m.csv@0..5 --test m.csv@5..9 --save-model m.csv",
    ),
    (
        "diagnose",
        "--next",
        "diagnose --model model.toml --train m.csv@0..5 --test m.csv@5..9 --next m.csv",
    ),
    ("identify", "--out", "identify o/report.html --out o"),
    ("identify", "--write", "identify m.csv --write m.csv"),
    (
        "benchmark rths",
        "--out",
        "benchmark rths --record o/rths.json --out o",
    ),
    (
        "benchmark rths",
        "--targets",
        "benchmark rths --record m.csv --case 1 --targets m.csv",
    ),
    (
        "benchmark marths",
        "--out",
        "benchmark marths --data data --out o",
    ),
    (
        "benchmark marths",
        "--targets",
        "benchmark marths --data data --records Kobe --targets data/marths/K_matrix.csv",
    ),
    (
        "board commission",
        "--out",
        "board commission table1.toml --emulated --signal m.csv --out m.csv",
    ),
    (
        "board calibrate",
        "--out",
        "board calibrate --port none --file o/calibration.toml --out o",
    ),
];

/// Places written by a verb without input, or that never exist before.
const WITHOUT_INPUT: [(&str, &str); 6] = [
    ("demo", "--out"),
    ("board identify", "--out"),
    ("board status", "--out"),
    ("board clear", "--out"),
    ("new", "[FILE]"),
    ("board desk", "--out"),
];

/// A folder with a test, a model, a record, and links with names that verbs write.
fn laboratory() -> tempfile::TempDir {
    let home = tempfile::tempdir().unwrap();
    let at = |name: &str| home.path().join(name);
    fs::copy(
        crate::common::root().join("examples/table1.toml"),
        at("table1.toml"),
    )
    .unwrap();
    for folder in ["o", "data/marths"] {
        fs::create_dir_all(at(folder)).unwrap();
    }
    let text = fs::read(at("table1.toml")).unwrap();
    for name in [
        "record.csv",
        "compare.json",
        "check.json",
        "sweep.csv",
        "tests.csv",
        "report.html",
        "difference.json",
        "replay.json",
        "summary.json",
        "calibration.toml",
        "model.toml",
        "rths.json",
        "table1-record.csv",
    ] {
        fs::write(at("o").join(name), &text).unwrap();
    }
    fs::write(
        at("model.toml"),
        "[actuator]\ngain = { value = 1.0, tolerance = 0.01 }\n",
    )
    .unwrap();
    let model = fs::read(at("model.toml")).unwrap();
    fs::write(at("o/model.toml"), model).unwrap();
    let rows = (0..10_000_i32).map(|i| {
        let t = f64::from(i) * 1e-3;
        format!("{t},{0},{0}\n", (3.0 * t).sin())
    });
    let head = std::iter::once("time_s,command_mm,displacement_mm\n".to_owned());
    fs::write(at("m.csv"), head.chain(rows).collect::<String>()).unwrap();
    fs::write(at("data/marths/K_matrix.csv"), "1\n").unwrap();
    home
}

fn in_folder(folder: &Path, line: &str) -> Output {
    let words: Vec<&str> = line.split(' ').collect();
    command(&words).current_dir(folder).output().unwrap()
}

/// Everything in a folder, with its path.
fn contents(folder: &Path) -> Vec<(std::path::PathBuf, Vec<u8>)> {
    let mut all = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => open.push(path),
                false => all.push((path.clone(), fs::read(path).unwrap())),
            }
        }
    }
    all.sort();
    all
}

#[cfg(unix)]
#[test]
fn no_verb_replaces_what_it_reads() {
    let home = laboratory();
    // The problem's stiffness is a link to a file that the report would replace.
    let stiffness = home.path().join("data/marths/K_matrix.csv");
    let before = contents(home.path());
    for (verb, option, line) in WRITTEN {
        if (verb, option) == ("benchmark marths", "--out") {
            fs::remove_file(&stiffness).unwrap();
            std::os::unix::fs::symlink("../../o/report.html", &stiffness).unwrap();
        }
        // Even with `--force`, which allows replacing records and files of another kind.
        let output = in_folder(home.path(), &format!("{line} --force"));
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {said}");
        let why = "would be replaced by what it writes to";
        assert!(said.contains(why), "{line}: {said}");
        assert_eq!(said.trim().lines().count(), 1, "{said}");
        if (verb, option) == ("benchmark marths", "--out") {
            fs::remove_file(&stiffness).unwrap();
            fs::write(&stiffness, "1\n").unwrap();
        }
        assert!(
            contents(home.path()) == before,
            "{line} has changed something"
        );
    }
    // For any spelling of the path.
    std::os::unix::fs::symlink("table1.toml", home.path().join("link.h5")).unwrap();
    for spelt in ["link.h5", "o/../table1.toml", "./table1.toml"] {
        let output = in_folder(home.path(), &format!("run table1.toml --archive {spelt}"));
        assert_eq!(output.status.code(), Some(2), "{spelt}");
    }
}

/// The options and arguments of a verb that take a file or a folder, and the verbs below it.
fn places(verb: &str) -> (Vec<String>, Vec<String>) {
    let words: Vec<&str> = verb
        .split(' ')
        .filter(|w| !w.is_empty())
        .chain(["--help"])
        .collect();
    let help = String::from_utf8(outerloop(&words).stdout).unwrap();
    let (mut places, mut verbs, mut part) = (Vec::new(), Vec::new(), "");
    for line in help.lines() {
        if !line.starts_with(' ') {
            part = line.trim();
            continue;
        }
        let entry = line.starts_with("  ") && !line.trim_start_matches(' ').is_empty();
        let words: Vec<&str> = line.split_whitespace().collect();
        match (part, &words[..]) {
            ("Commands:", [name, ..])
                if entry && line.starts_with("  ") && !line.starts_with("   ") =>
            {
                verbs.push((*name).to_owned());
            }
            ("Arguments:", [name, ..])
                if line.starts_with("  ")
                    && !line.starts_with("   ")
                    && name.starts_with(['<', '[']) =>
            {
                places.push((*name).to_owned())
            }
            ("Options:", [option, value, ..])
                if option.starts_with("--")
                    && ["<DIR>", "<FILE", "<DEV>", "<TEST.toml>", "<SHAPE|FILE>"]
                        .iter()
                        .any(|v| value.starts_with(v)) =>
            {
                places.push((*option).to_owned());
            }
            _ => {}
        }
    }
    (places, verbs)
}

#[test]
fn every_place_that_a_verb_writes_to_is_tried_above() {
    let mut open = vec![String::new()];
    let mut untried = BTreeSet::new();
    let mut seen = 0;
    while let Some(verb) = open.pop() {
        let (places, verbs) = places(&verb);
        for place in places {
            let plain = place.trim_end_matches("...");
            seen += 1;
            let read = READ.contains(&plain)
                || [
                    "<SECOND>",
                    "[TEST]",
                    "[FILTER]",
                    "[WHAT]",
                    "<FILE[@T0..T1]>",
                    "<SHELL>",
                ]
                .contains(&plain);
            let tried = WRITTEN.iter().any(|(v, o, _)| *v == verb && *o == plain)
                || WITHOUT_INPUT.contains(&(verb.as_str(), plain));
            if !read && !tried {
                untried.insert(format!("{verb} {plain}"));
            }
        }
        let below = verbs.into_iter().filter(|name| name != "help");
        open.extend(below.map(|name| format!("{verb} {name}").trim().to_owned()));
    }
    assert!(seen > 35, "the help is not read any more: {seen}");
    assert_eq!(
        untried,
        BTreeSet::new(),
        "say above what becomes of an input there"
    );
}

#[test]
fn a_record_that_cannot_be_made_again_is_not_replaced_unasked() {
    let home = laboratory();
    let kept = r#"{"verdict": "stopped"}"#;
    fs::create_dir(home.path().join("first")).unwrap();
    fs::write(home.path().join("first/summary.json"), kept).unwrap();
    let run = "run table1.toml --duration 3 --out first";
    let output = in_folder(home.path(), run);
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(
        said.contains("first-2") && said.contains("--force"),
        "{said}"
    );
    let told = String::from_utf8(output.stdout).unwrap();
    assert!(told.contains("first-2/report.html"), "{told}");
    assert!(home.path().join("first-2/record.h5").exists());
    assert_eq!(
        fs::read_to_string(home.path().join("first/summary.json")).unwrap(),
        kept
    );
    let output = in_folder(home.path(), &format!("{run} --force"));
    assert!(output.status.success(), "{output:?}");
    assert!(home.path().join("first/record.h5").exists());
}

/// A file named by mistake may be a measurement: only one of the same kind is replaced.
#[test]
fn a_file_of_another_kind_is_not_replaced_unasked() {
    let home = laboratory();
    let measured = "time_s,displacement_mm,force_n\n0,1,2\n1,2,3\n";
    fs::write(home.path().join("raw.csv"), measured).unwrap();
    let diagnose = "diagnose --model model.toml --train m.csv@0..5 --test m.csv@5..9";
    for line in [
        "run table1.toml --duration 3 --archive raw.csv".to_owned(),
        format!("{diagnose} --save-model raw.csv"),
        format!("{diagnose} --save-model table1.toml"),
        format!("{diagnose} --next raw.csv"),
        "benchmark rths --record m.csv --case 1 --targets raw.csv".to_owned(),
        "benchmark marths --data data --records Kobe --targets raw.csv".to_owned(),
        "board commission table1.toml --emulated --out raw.csv".to_owned(),
        "new raw.csv --from table1".to_owned(),
        "new --model raw.csv".to_owned(),
        "new --signal raw.csv".to_owned(),
    ] {
        let before = contents(home.path());
        let output = in_folder(home.path(), &line);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {said}");
        assert!(
            said.contains("is there already") && said.contains("--force"),
            "{line}: {said}"
        );
        assert!(contents(home.path()) == before, "{line}: {said}");
    }
    fs::rename(home.path().join("raw.csv"), home.path().join("raw.h5")).unwrap();
    let archive = "run table1.toml --duration 3 --archive raw.h5";
    let refused = in_folder(home.path(), archive);
    assert_eq!(refused.status.code(), Some(2), "{refused:?}");
    let forced = in_folder(home.path(), &format!("{archive} --force"));
    assert!(forced.status.success(), "{forced:?}");
    let again = in_folder(home.path(), archive);
    assert!(
        again.status.success(),
        "an archive replaces an archive: {again:?}"
    );
}

#[cfg(unix)]
#[test]
fn an_archive_that_cannot_be_made_again_is_kept() {
    let home = laboratory();
    let archive = home.path().join("kept.h5").display().to_string();
    let line = ["run", "examples/table1.toml", "--archive", &archive];
    let scope = command(&[&line[..], &["--scope"]].concat());
    let (mut running, _said, _) = crate::common::started(scope, "http");
    std::thread::sleep(std::time::Duration::from_secs(2));
    crate::common::send_signal(&running, "-TERM");
    assert_eq!(running.wait().unwrap().code(), Some(1));
    let kept = fs::read(&archive).unwrap();
    let again = outerloop(&[&line[..], &["--duration", "3"]].concat());
    let said = String::from_utf8_lossy(&again.stderr);
    assert_eq!(again.status.code(), Some(2), "{said}");
    assert!(
        said.contains("stopped by hand") && said.contains("--force"),
        "{said}"
    );
    assert!(fs::read(&archive).unwrap() == kept);
}

#[test]
fn two_results_of_a_command_do_not_go_to_one_file() {
    let home = laboratory();
    for folder in ["a", "b"] {
        fs::create_dir(home.path().join(folder)).unwrap();
        let test = home.path().join(folder).join("x.toml");
        fs::copy(
            crate::common::root().join("examples/undeclared/friction.toml"),
            test,
        )
        .unwrap();
    }
    for line in [
        "improve a/x.toml b/x.toml --out p",
        "run table1.toml --duration 3 --out p --archive p/report.html",
        "diagnose --model model.toml --train m.csv@0..5 --test m.csv@5..9 --save-model n --next n",
    ] {
        let output = in_folder(home.path(), line);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{line}: {said}");
        assert!(said.contains("two results of this command"), "{said}");
        assert!(!home.path().join("n").exists() && !home.path().join("p").exists());
    }
}
