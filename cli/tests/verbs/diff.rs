//! `outerloop diff`: two completed tests, side by side.

use crate::common::{json, json_with, outerloop, refused};
use serde_json::Value;
use std::path::Path;

/// With an ideal actuator.
const IDEAL: [&str; 4] = [
    "--compensation",
    "none",
    "--set",
    "plant.actuator.delay_ms=0",
];

/// Six seconds of a test, written to `folder`, and its summary.
fn ran(folder: &Path, name: &str, more: &[&str]) -> (String, Value) {
    let out = folder.join(name).display().to_string();
    let mut arguments = vec!["run", "examples/table1.toml", "--json", "--out", &out];
    arguments.extend(["--duration", "6"]);
    arguments.extend(more);
    let summary = json(&arguments);
    (out, summary)
}

fn channel<'a>(difference: &'a Value, name: &str) -> &'a Value {
    let mut channels = difference["channels"].as_array().unwrap().iter();
    channels.find(|c| c["channel"] == name).unwrap()
}

#[test]
fn against_an_ideal_rig_the_difference_is_equation_18() {
    let folder = tempfile::tempdir().unwrap();
    let (ideal, _) = ran(folder.path(), "ideal", &IDEAL);
    let (paper, summary) = ran(folder.path(), "paper", &[]);
    let out = folder.path().join("both").display().to_string();
    let difference = json(&["diff", &ideal, &paper, "--json", "--out", &out]);
    let compared = json(&["compare", &ideal, &paper, "--json"]);
    assert_eq!(
        compared["channels"], difference["channels"],
        "the same by its other name"
    );
    let target = channel(&difference, "target_m");
    for (own, key) in [("rms_of_peak", "eps_rms"), ("peak", "peak_displacement_m")] {
        let (own, other) = (
            target[own].as_f64().unwrap(),
            summary[key].as_f64().unwrap(),
        );
        let share = if key == "eps_rms" { 1e-5 } else { 0.1 };
        assert!((own / other - 1.0).abs() < share, "{key}: {own} {other}");
    }
    let most = target["largest"].as_f64().unwrap() / target["peak"].as_f64().unwrap();
    assert!((most / summary["eps_max"].as_f64().unwrap() - 1.0).abs() < 1e-5);
    let keys: Vec<&str> = difference["settings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|s| s["key"].as_str().unwrap())
        .collect();
    assert_eq!(keys, ["method", "plant.actuator.delay_ms"]);
    let page = std::fs::read_to_string(Path::new(&out).join("report.html")).unwrap();
    assert!(page.contains("Two tests side by side") && !page.contains(">NaN"));
}

#[test]
fn the_same_test_twice_has_no_difference() {
    let folder = tempfile::tempdir().unwrap();
    let (first, _) = ran(folder.path(), "first", &[]);
    let (second, _) = ran(folder.path(), "second", &[]);
    let said = outerloop(&["diff", &first, &second, "--within", "0"]);
    assert!(said.status.success());
    let said = String::from_utf8(said.stdout).unwrap();
    assert!(
        said.contains("The same test") && said.contains("the same to the bit"),
        "{said}"
    );
}

#[test]
fn a_slower_test_is_compared_in_model_time_and_too_far_apart_is_a_failure() {
    let folder = tempfile::tempdir().unwrap();
    let (fast, _) = ran(folder.path(), "fast", &IDEAL);
    let mut slower = IDEAL.to_vec();
    slower.extend(["--set", "loop.time_scale=4", "--set", "loop.substeps=2"]);
    let (slow, _) = ran(folder.path(), "slow", &slower);
    let difference = json(&["diff", &fast, &slow, "--json"]);
    let compared_s = difference["compared_s"].as_f64().unwrap();
    assert!((compared_s - 6.0).abs() < 0.01, "{compared_s}");
    let apart = channel(&difference, "target_m")["rms_of_peak"]
        .as_f64()
        .unwrap();
    // Two integration steps for the same motion: the period of explicit Newmark is off by (omega dt)^2 / 24.
    assert!(apart > 0.0 && apart < 1e-3, "{apart}");
    let (late, _) = ran(
        folder.path(),
        "late",
        &[
            "--compensation",
            "none",
            "--set",
            "plant.actuator.delay_ms=1",
        ],
    );
    let status = json_with(1, &["diff", &fast, &late, "--json", "--within", "0.001"]);
    assert!(
        channel(&status, "target_m")["rms_of_peak"]
            .as_f64()
            .unwrap()
            > 0.001
    );
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (one, _) = ran(folder.path(), "one", &[]);
    let three = folder.path().join("three").display().to_string();
    json(&[
        "run",
        "examples/three-storey.toml",
        "--json",
        "--duration",
        "2",
        "--out",
        &three,
    ]);
    refused(
        &["diff", &one, &three],
        &["floors: 1", "floors: 3", "as many floors"],
    );
    refused(
        &["diff", &one, "examples/table1.toml"],
        &["table1.toml", "is no archive"],
    );
    refused(
        &["diff", &one, &one, "--within", "-1"],
        &["--within -1", "share"],
    );
    refused(
        &["diff", &one, folder.path().to_str().unwrap()],
        &["record.h5"],
    );
}
