//! `outerloop benchmark rths`: the targets, on the problem's records where they are, and on an earthquake of our own.
#![allow(missing_docs)]

use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn benchmark(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .args(["benchmark", "rths"])
        .args(arguments)
        .output()
        .expect("the tool runs")
}

fn answer(arguments: &[&str]) -> Value {
    let output = benchmark(arguments);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

fn worst<'a>(answer: &'a Value, controller: &str) -> &'a Value {
    let all = answer["worst"].as_array().unwrap();
    all.iter().find(|w| w["controller"] == controller).unwrap()
}

fn percent(of: &Value, name: &str) -> f64 {
    of[name].as_f64().unwrap()
}

fn holds_the_targets(answer: &Value) {
    let best = worst(answer, "tangent+ats");
    assert!(percent(best, "j2_without_noise") <= 2.0, "{best}");
    assert!(percent(best, "j4_without_noise") <= 3.0, "{best}");
    assert!(percent(best, "j4_own_perturbed") < 10.0, "{best}");
    assert_eq!(best["lost"], 0);
    // As read: what is left, and the noise of the sensor, which has nothing to do with it.
    for row in answer["rows"].as_array().unwrap() {
        if row["controller"] == "tangent+ats" {
            let left = row["j_without_noise"][1].as_f64().unwrap();
            let (read, noise) = (row["j"][1].as_f64().unwrap(), percent(row, "j2_of_noise"));
            assert!((read / left.hypot(noise) - 1.0).abs() < 0.03, "{row}");
        }
    }
    // The tangent force is worth its while behind a fixed inverse, and adaptation more; both against the baseline.
    let own = |name| percent(worst(answer, name), "j4_own_perturbed");
    assert!(own("tangent+inverse-model") < 0.7 * own("feedforward-feedback"));
    assert!(own("tangent+ats") <= own("tangent+inverse-model"));
    assert!(own("tangent+inverse-model") < 0.3 * own("pi-phase-lead"));
}

const FOUR: &str = "pi-phase-lead,tangent+ats,tangent+inverse-model,feedforward-feedback";

#[test]
fn the_targets_are_reached_on_all_cases_and_records() {
    let Some(records) = test_data::file("ground-motion/RTHSBENCH_ElCentro.csv") else {
        return;
    };
    let folder = records.ancestors().nth(2).unwrap().to_owned();
    let folder = folder.to_string_lossy();
    let answer = answer(&[
        "--json",
        "--plants",
        "4",
        "--controllers",
        FOUR,
        "--data",
        &folder,
    ]);
    assert_eq!(answer["rows"].as_array().unwrap().len(), 3 * 4 * 4);
    holds_the_targets(&answer);
}

/// 30 s of decaying noise, the same every time, as a ground motion in g.
fn earthquake(folder: &Path) -> PathBuf {
    let mut text = String::from("time_s,acc_g\n");
    let mut state = 1_u64;
    for i in 0..1500 {
        let t = f64::from(i) * 0.02;
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        let noise = (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
        let strength = (t / 3.0) * (1.0 - t / 3.0).exp();
        writeln!(text, "{t:.4},{:.6}", 0.7 * noise * strength).unwrap();
    }
    let file = folder.join("decaying-noise.csv");
    std::fs::write(&file, text).unwrap();
    file
}

#[test]
fn the_targets_are_reached_on_an_earthquake_of_our_own_and_the_report_stands_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = earthquake(folder.path());
    let out = folder.path().join("out");
    let (file, out_text) = (file.to_string_lossy(), out.to_string_lossy());
    let arguments = [
        "--json",
        "--plants",
        "2",
        "--controllers",
        FOUR,
        "--record",
        &file,
        "--out",
        &out_text,
    ];
    let found = answer(&arguments);
    holds_the_targets(&found);
    let page = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("decaying-noise") && page.contains("<svg") && !page.contains("NaN"));
    assert!(!page.contains("<script") && !page.contains("href="));
    let written: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("rths.json")).unwrap()).unwrap();
    assert_eq!(written, found);
    assert_eq!(answer(&arguments), found, "seeded runs repeat");
}

#[test]
fn bad_input_is_refused_in_one_sentence() {
    for (arguments, said) in [
        (
            &["--controllers", "magic"][..],
            "the controller `magic` is unknown",
        ),
        (
            &["--plants", "2000"],
            "--plants 2000: accepted are 0 to 1000",
        ),
        (&["--record", "nowhere.csv"], "nowhere.csv"),
    ] {
        let output = benchmark(arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            text.contains(said) && text.trim().lines().count() == 1,
            "{text}"
        );
    }
}
