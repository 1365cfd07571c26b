//! The provenance in every result; the reports of `check` and `monte-carlo`.

use crate::common::{is_as_its_schema_says, json, json_with, outerloop};
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

/// The columns of `record.csv` with these names.
fn columns<const N: usize>(folder: &Path, names: [&str; N]) -> Vec<[f64; N]> {
    let text = std::fs::read_to_string(folder.join("record.csv")).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let places = names.map(|name| head.iter().position(|h| *h == name).expect(name));
    let rows = lines.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        places.map(|place| cells[place].parse().unwrap())
    });
    rows.collect()
}

/// By how much the force of a spring follows its displacement, ms: `f = k (x - T v)`, where `v` is the difference of neighbours.
fn force_late_ms(rows: &[[f64; 3]]) -> f64 {
    let (mut xx, mut xv, mut vv, mut fx, mut fv) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for near in rows.windows(3) {
        let [[t0, x0, _], [_, x, f], [t1, x1, _]] = [near[0], near[1], near[2]];
        let v = (x1 - x0) / (t1 - t0);
        (xx, xv, vv) = (xx + x * x, xv + x * v, vv + v * v);
        (fx, fv) = (fx + f * x, fv + f * v);
    }
    let (k, c) = (fx * vv - fv * xv, fv * xx - fx * xv);
    -1e3 * c / k
}

#[test]
fn the_lateness_of_the_force_is_said_in_json_and_on_the_page_and_is_what_was_put_in() {
    const SKEW_MS: f64 = 1.5;
    let folder = tempfile::tempdir().unwrap();
    let out = |name: &str| folder.path().join(name);
    let effect = format!("plant.effects=[{{name='channel_skew',skew_ms={SKEW_MS}}}]");
    let known = format!("rig.force_late_ms=[{SKEW_MS}]");
    let run = |name: &str, method: &str, set: &[&str], status: i32| {
        let out = out(name).display().to_string();
        let mut words = vec!["run", TABLE1, "--duration", "10", "--compensation", method];
        words.extend(["--set", &effect, "--out", &out, "--json"]);
        words.extend(set.iter().flat_map(|set| ["--set", set]));
        json_with(status, &words)
    };
    let late = |answer: &Value| -> Vec<String> {
        let remarks = answer["remarks"].as_array().unwrap().iter();
        let remarks = remarks.map(|remark| remark.as_str().unwrap().to_owned());
        remarks.filter(|r| r.contains("waits")).collect()
    };
    // Nobody has told the loop, and the record shows it.
    let untold = run("untold", "paper", &[], 1);
    assert_eq!(late(&untold), [""; 0]);
    let found_ms = force_late_ms(&columns(
        &out("untold"),
        ["time_s", "displacement_m", "force_n"],
    ));
    println!("the force is {found_ms:.3} ms late in the record");
    assert!((found_ms - SKEW_MS).abs() < 0.02, "{found_ms}");
    let told = run("told", "paper", &[&known], 0);
    let sentences = late(&told);
    let [sentence] = &sentences[..] else {
        panic!("{told}")
    };
    let said = sentence
        .split_once("waits ")
        .unwrap()
        .1
        .split_once(" ms")
        .unwrap()
        .0;
    assert_eq!(said, format!("{found_ms:.2}").as_str(), "{sentence}");
    page(&out("told"), &[sentence]);
    is_as_its_schema_says("run", &told, "remarks");
    let terminal = outerloop(&[
        "run",
        TABLE1,
        "--duration",
        "10",
        "--set",
        &effect,
        "--set",
        &known,
    ]);
    let terminal = String::from_utf8(terminal.stdout).unwrap();
    let one_line = terminal.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(one_line.contains(sentence.as_str()), "{terminal}");
    // With the predictor that it names, and the delay that it says is missing, there is nothing left to say.
    let delay = format!("compensation.delay_ms={}", 4.0 + SKEW_MS);
    let ahead = run("ahead", "paper+afp", &[&known, &delay], 0);
    assert_eq!(late(&ahead), [""; 0]);
    let eps = [&told, &ahead].map(|answer| answer["eps_rms"].as_f64().unwrap());
    println!("eps_rms {eps:?}");
    assert!(eps[1] < 0.05 * eps[0], "{eps:?}");
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
        "The test file, with what --set changed",
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
