//! `outerloop sweep`: one row per test, the same figures as `run`, drawn rigs, errors that name the cause.

use crate::common::{command, json, outerloop, refused, send_signal};
use std::process::Stdio;

const TABLE1: &str = "examples/table1.toml";

#[test]
fn each_row_is_the_test_that_run_runs() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let over = "plant.actuator.delay_ms=0..8/3";
    let swept = json(&[
        "sweep",
        TABLE1,
        "--over",
        over,
        "--compensations",
        "none,paper",
        "--duration",
        "5",
        "--out",
        out,
        "--json",
    ]);
    let rows = swept["rows"].as_array().unwrap();
    let of: Vec<(f64, &str)> = rows
        .iter()
        .map(|r| {
            (
                r["value"].as_f64().unwrap(),
                r["compensation"].as_str().unwrap(),
            )
        })
        .collect();
    assert_eq!(
        of,
        [
            (0.0, "none"),
            (0.0, "paper"),
            (4.0, "none"),
            (4.0, "paper"),
            (8.0, "none"),
            (8.0, "paper")
        ]
    );
    let set = "plant.actuator.delay_ms=8";
    let alone = json(&["run", TABLE1, "--set", set, "--duration", "5", "--json"]);
    for key in ["eps_rms", "eps_max", "peak_displacement_m", "verdict"] {
        assert_eq!(rows[5][key], alone[key], "{key}");
    }
    let text = std::fs::read_to_string(folder.path().join("sweep.csv")).unwrap();
    assert_eq!(text.lines().count(), 7);
    let html = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(html.contains("<b>paper</b>") && html.contains("<svg"));
}

#[test]
fn mistakes_are_named() {
    let over = |text| ["sweep", TABLE1, "--over", text];
    refused(&over("plant.actuator.delay_ms"), &["--over", "has no `=`"]);
    refused(&over("loop.rate=1,2"), &["loop.rate=1", "rate_hz"]);
    refused(
        &over("plant.actuator.delay_ms=-5..5/3"),
        &["plant.actuator.delay_ms", "-5"],
    );
    refused(&["sweep", TABLE1], &["--over", "missing"]);
    refused(
        &[
            "sweep",
            TABLE1,
            "--drawn",
            "20",
            "--compensations",
            "none,paper",
        ],
        &["--drawn", "one compensation"],
    );
    let lost = outerloop(&[
        "sweep",
        TABLE1,
        "--over",
        "plant.actuator.delay_ms=40,60",
        "--compensations",
        "none",
    ]);
    assert!(String::from_utf8_lossy(&lost.stdout).contains("lost"));
}

#[cfg(unix)]
#[test]
fn a_page_of_tests_that_were_ended_early_begins_with_how_many_ran() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out").display().to_string();
    let mut sweep = command(&["sweep", TABLE1, "--drawn", "20000", "--out", &out]);
    let mut running = sweep
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_secs(2));
    send_signal(&running, "-HUP");
    assert_eq!(running.wait().unwrap().code(), Some(1));
    let page = std::fs::read_to_string(folder.path().join("out/report.html")).unwrap();
    let first = page.split("<p class=\"verdict").nth(1).unwrap();
    assert!(
        first.contains("of 20000 tests ran, and only they"),
        "{first:.200}"
    );
}
