//! The provenance in every result; the reports of `check` and `monte-carlo`.

use crate::common::{json, json_with, outerloop};
use serde_json::Value;
use std::path::Path;

const TABLE1: &str = "examples/table1.toml";

/// Date, operator, command, version and hashes; the seed of everything random.
#[track_caller]
fn has_origin(answer: &Value, verb: &str, seed: Option<u64>) {
    let origin = &answer["provenance"];
    let text = |key: &str| origin[key].as_str().unwrap_or_default();
    assert!(
        text("command").starts_with(&format!("outerloop {verb}")),
        "{origin}"
    );
    assert_eq!(text("program_sha256").len(), 64, "{origin}");
    for key in ["date", "operator", "machine", "folder", "version"] {
        assert!(!text(key).is_empty(), "{key}: {origin}");
    }
    assert_eq!(origin["seed"].as_u64(), seed, "{origin}");
}

#[test]
fn every_answer_in_json_says_who_when_and_with_what() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let signal = at("signal.csv");
    // One sine of 2 mm, from rest to rest.
    let points = (0..=2000_i32).map(|i| {
        let t = f64::from(i) * 1e-3;
        format!(
            "{t},{:.4}\n",
            2.0 * (std::f64::consts::PI * t).sin().powi(2)
        )
    });
    let text: String = std::iter::once("time_s,command_mm\n".to_owned())
        .chain(points)
        .collect();
    std::fs::write(&signal, text).unwrap();
    let archive = at("test.h5");
    let kept = outerloop(&["run", TABLE1, "--duration", "8", "--archive", &archive]);
    assert!(kept.status.success(), "{kept:?}");
    let random: [(&str, &[&str]); 4] = [
        ("run", &[TABLE1, "--duration", "8"]),
        ("run", &[TABLE1, "--signal", &signal]),
        ("monte-carlo", &[TABLE1, "--tests", "2", "--duration", "8"]),
        ("improve", &["examples/undeclared/inertia.toml"]),
    ];
    for (verb, words) in random {
        let arguments = [&[verb], words, &["--seed", "3", "--json"]].concat();
        let output = outerloop(&arguments);
        let answer = serde_json::from_slice(&output.stdout).expect("one JSON object");
        has_origin(&answer, verb, Some(3));
    }
    has_origin(&json(&["replay", &archive, "--json"]), "replay", None);
    let answer = json(&["replay", &archive, "--json"]);
    let files = answer["provenance"]["files"].as_array().unwrap();
    assert_eq!(files[0]["file"], archive.as_str());
}

/// The page of a folder: it needs no other files, and no number in it has overflowed.
#[track_caller]
fn page(folder: &Path, says: &[&str]) -> String {
    let page = std::fs::read_to_string(folder.join("report.html")).unwrap();
    for alone in ["src=", "<link", "href=\"http", ">NaN", " NaN"] {
        assert!(!page.contains(alone), "{alone}");
    }
    for words in says {
        assert!(page.contains(words), "{words}");
    }
    page
}

#[test]
fn a_check_has_a_report_whatever_its_verdict_is() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let arguments = ["check", TABLE1, "--plants", "20", "--json", "--out", out];
    let said = json(&arguments);
    assert_eq!(said["verdict"], "stable");
    let text = std::fs::read_to_string(folder.path().join("check.json")).unwrap();
    let written: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(written, said);
    let words = [
        "STABLE",
        "0 of 20",
        "Where the delay comes from",
        "The test file, as it was used",
        "SHA-256",
        "<dt>seed</dt>",
    ];
    let stable = page(folder.path(), &words);
    let verdict = stable.find("class=\"verdict good\"").unwrap();
    let (picture, table) = (stable.find("<svg").unwrap(), stable.find("<table").unwrap());
    assert!(
        verdict < picture && picture < table,
        "verdict, picture, table"
    );

    let arguments = [&arguments[..], &["--compensation", "none"]].concat();
    let said = json_with(2, &arguments);
    assert_eq!(said["verdict"], "unstable");
    page(folder.path(), &["class=\"verdict bad\"", "UNSTABLE"]);
}

#[test]
fn many_tests_have_a_report_with_a_dot_each_and_a_line_each() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let arguments = [
        "monte-carlo",
        TABLE1,
        "--tests",
        "40",
        "--json",
        "--out",
        out,
    ];
    let said = json(&arguments);
    let page = page(
        folder.path(),
        &["40 of 40 tests ran to their end", "The worst of them"],
    );
    // Three plots of 40 dots.
    let paths = page
        .split(" d=\"")
        .skip(1)
        .filter_map(|p| p.split('"').next());
    let dots: usize = paths.map(|p| p.matches("h0").count()).sum();
    assert_eq!(dots, 120);
    let tests = std::fs::read_to_string(folder.path().join("tests.csv")).unwrap();
    let errors: Vec<f64> = tests
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(5).unwrap().parse().unwrap())
        .collect();
    assert_eq!(errors.len(), 40);
    let worst = errors.iter().copied().fold(0.0, f64::max);
    assert_eq!(said["eps_rms_worst"], worst);
}

#[test]
fn the_page_of_a_watched_test_draws_what_was_named_and_when() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let arguments = |test: &str| {
        let set = "watch.correct=['lateness']";
        let place = out.to_str().unwrap();
        let asked = ["run", test, "--duration", "14", "--json", "--force"];
        let ran = json(&[&asked[..], &["--set", set, "--out", place]].concat());
        (
            ran,
            std::fs::read_to_string(out.join("report.html")).unwrap(),
        )
    };
    let (ran, page) = arguments("examples/rig-watch.toml");
    let events = ran["watch"]["events"].as_array().unwrap();
    assert!(page.contains("What the watch saw"));
    let since = |at: usize| {
        let t_s = events[at]["t_s"].as_f64().unwrap();
        format!("{} since {t_s:.2} s", events[at]["state"].as_str().unwrap())
    };
    // The last event has the final state of the test; its line says since when this has been unchanged.
    let end = events.len() - 1;
    for at in 0..end {
        let line = format!("<li>{}", since(at));
        assert!(page.contains(&line), "{line}");
    }
    let only_late = |e: &Value| e["set"].as_array().is_some_and(|s| s.len() == 1);
    let settled = events.iter().position(only_late).unwrap();
    let line = format!("<li>at the end: {}", since(settled));
    assert!(settled < end && page.contains(&line), "{line}");
    assert!(
        page.contains("delay_error of the actuator")
            && page.contains("; delay_error is corrected for by ")
    );
    // The record behind the name is also diagnosed, and the sentence gives the result.
    let diagnosis = &ran["watch"]["diagnosis"];
    assert!(page.contains(diagnosis["sentence"].as_str().unwrap()));
    // A test without events has no such section.
    let sound = arguments("examples/table1.toml").1;
    assert!(!sound.contains("What the watch saw"));
}
