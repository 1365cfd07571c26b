//! The binary as people and scripts call it: keys, exit statuses, errors in one clear sentence, nothing half written.

use crate::common::{KEYS, json, json_with, outerloop, refused};
use serde_json::Value;

const TABLE1: &str = "examples/table1.toml";

#[test]
fn run_prints_every_key_of_the_contract() {
    let r = json(&["run", TABLE1, "--json", "--duration", "10"]);
    for key in KEYS {
        assert!(r.get(key).is_some(), "{key}");
    }
    assert_eq!(r["verdict"], "completed");
    assert_eq!(r["compensation"], "paper");
    assert_eq!(r["steps"], 20_000);
    assert!(r["trip"].is_null());
    assert!(r["eps_rms"].as_f64().unwrap() < 0.02);
}

#[test]
fn without_compensation_the_verdict_is_diverged() {
    let r = json_with(1, &["run", TABLE1, "--json", "--compensation", "none"]);
    assert_eq!(r["verdict"], "diverged");
    assert!(r["eps_max"].as_f64().unwrap() > 1.0);
}

#[test]
fn the_same_seed_gives_the_same_test_and_another_does_not() {
    let run = |seed| {
        let mut r = json(&[
            "run",
            "examples/steel-frame.toml",
            "--json",
            "--duration",
            "2",
            "--seed",
            seed,
        ]);
        let answer = r.as_object_mut().unwrap();
        answer.remove("wall_s");
        answer.remove("provenance");
        r
    };
    assert_eq!(run("7"), run("7"));
    assert_ne!(run("7"), run("8"));
}

#[test]
fn a_value_can_be_set_from_outside() {
    let error = |delay: &str| {
        let set = format!("plant.actuator.delay_ms={delay}");
        json(&["run", TABLE1, "--json", "--duration", "10", "--set", &set])["eps_rms"]
            .as_f64()
            .unwrap()
    };
    assert!(error("8") > 2.0 * error("2"));
}

#[test]
fn the_damping_needs_the_delay_for_its_clamp_alone() {
    let error = |told_ms: &str| {
        let set = format!("compensation.delay_ms={told_ms}");
        json(&["run", TABLE1, "--json", "--set", &set])["eps_rms"]
            .as_f64()
            .unwrap()
    };
    let right = error("4");
    for told_ms in ["2", "16"] {
        let told = error(told_ms);
        assert!(
            (told / right - 1.0).abs() < 0.15,
            "{told_ms} ms: {told} for {right}"
        );
    }
}

#[test]
fn a_trip_is_exit_status_1_and_says_which_limit() {
    let output = outerloop(&["run", TABLE1, "--json", "--set", "limits.force_n=3000"]);
    assert_eq!(output.status.code(), Some(1));
    let r: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        (r["verdict"].as_str(), r["trip"].as_str()),
        (Some("tripped"), Some("force"))
    );
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains("force") && said.contains("limit of 3.00 kN"),
        "{said}"
    );
}

#[test]
fn every_example_completes() {
    for example in [
        "table1",
        "steel-frame",
        "three-storey",
        "hybrid",
        "hydraulic-ram",
    ] {
        let file = format!("examples/{example}.toml");
        let r = json(&["run", &file, "--json"]);
        assert_eq!(r["verdict"], "completed", "{example}");
        assert!(r["eps_rms"].as_f64().unwrap() < 0.05, "{example}: {r}");
    }
}

#[test]
fn compare_gives_a_row_each() {
    let r = json(&[
        "compare",
        TABLE1,
        "--compensations",
        "none,paper",
        "--json",
        "--duration",
        "10",
    ]);
    let names: Vec<_> = r["rows"]
        .as_array()
        .unwrap()
        .iter()
        .map(|r| r["compensation"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["none", "paper"]);
}

#[test]
fn effects_lists_every_fixed_name() {
    let r = json(&["effects", "--json"]);
    let names: Vec<_> = r
        .as_array()
        .unwrap()
        .iter()
        .map(|e| e["name"].as_str().unwrap())
        .collect();
    for name in [
        "delay_error",
        "lag_error",
        "second_lag",
        "oil_column",
        "channel_skew",
        "gain_error",
        "offset",
        "rig_compliance",
        "drift",
        "temperature_gain",
        "coulomb_friction",
        "stribeck_friction",
        "bilinear_hysteresis",
        "bouc_wen_hysteresis",
        "backlash",
        "dead_band",
        "slip_gap",
        "saturation",
        "rate_limit",
        "viscous_damping",
        "quadratic_damping",
        "maxwell_damper",
        "hardening",
        "softening",
        "degradation",
        "asymmetric_actuator",
        "asymmetric_stiffness",
        "inertia_force",
        "mains_hum",
        "quantisation",
    ] {
        assert!(names.contains(&name), "{name}");
    }
}

#[test]
fn out_writes_a_report_that_needs_nothing_beside_it_and_a_record_that_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    json(&["run", TABLE1, "--json", "--duration", "5", "--out", out]);
    let html = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(html.matches("<svg").count() >= 6);
    assert!(!html.contains("<link") && !html.contains(" src=") && !html.contains("@import"));
    let csv = std::fs::read_to_string(folder.path().join("record.csv")).unwrap();
    let mut lines = csv.lines();
    let names: Vec<_> = lines.next().unwrap().split(',').collect();
    assert_eq!(
        &names[..4],
        ["time_s", "command_m", "displacement_m", "force_n"]
    );
    let mut rows = 0;
    for line in lines {
        let cells: Vec<f32> = line.split(',').map(|c| c.parse().unwrap()).collect();
        assert_eq!(cells.len(), names.len());
        // A linear specimen: the written force is the stiffness times the written displacement.
        assert!((cells[3] - 158e3 * cells[2]).abs() <= 1e-6 * cells[3].abs() + 1e-3);
        rows += 1;
    }
    assert_eq!(rows, 10_000);
    let left: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|f| f.unwrap().file_name())
        .collect();
    assert_eq!(left.len(), 4, "nothing half written: {left:?}");
}

#[test]
fn a_plain_column_is_read_with_its_interval_and_unit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sine.txt");
    let text: String = (0..500)
        .map(|i| format!("{}\n", 50.0 * (f64::from(i) * 0.12).sin()))
        .collect();
    std::fs::write(&path, text).unwrap();
    let record = path.to_str().unwrap();
    let run = |dt: &str, unit: &str| {
        json(&[
            "run", TABLE1, "--json", "--record", record, "--dt", dt, "--unit", unit,
        ])
    };
    let gal = run("0.01", "gal");
    assert_eq!(
        (gal["record"].as_str(), gal["steps"].as_u64()),
        (Some("sine"), Some(80_000))
    );
    let peak = |r: &Value| r["peak_displacement_m"].as_f64().unwrap();
    let ratio = peak(&run("0.01", "m/s2")) / peak(&gal);
    assert!((ratio - 100.0).abs() < 0.05, "a linear structure: {ratio}");
}

#[test]
fn a_test_that_outlasts_its_record_ends_in_rest() {
    let long = json(&["run", TABLE1, "--json", "--duration", "90"]);
    assert_eq!(long["steps"].as_u64(), Some(180_000));
    let short = json(&["run", TABLE1, "--json"]);
    assert_eq!(
        long["eps_max"], short["eps_max"],
        "nothing new after the end"
    );
}

#[test]
fn the_frame_moves_as_far_as_its_file_wants() {
    let r = json(&["run", "examples/steel-frame.toml", "--json"]);
    let peak = r["peak_displacement_m"].as_f64().unwrap();
    assert!((peak / 6e-3 - 1.0).abs() < 0.05, "{peak}");
}

#[test]
fn the_demonstration_needs_no_input() {
    let folder = tempfile::tempdir().unwrap();
    let output = outerloop(&["demo", "--out", folder.path().to_str().unwrap()]);
    assert!(output.status.success());
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(said.contains("diverged") && said.contains("paper"));
    assert!(folder.path().join("report.html").exists());
}

#[test]
fn every_compensation_answers_to_its_name_in_every_place() {
    let duration = ["--json", "--duration", "2"];
    let all = json(&[&["compare", TABLE1][..], &duration].concat());
    let rows = all["rows"].as_array().unwrap();
    assert_eq!(rows.len(), outerloop_core::Method::ALL.len());
    for row in rows {
        let name = row["compensation"].as_str().unwrap();
        let set = format!("compensation.kind={name}");
        let by_key = json(&[&["run", TABLE1, "--set", &set][..], &duration].concat());
        let by_option = json(&[&["run", TABLE1, "--compensation", name][..], &duration].concat());
        for key in ["compensation", "eps_rms", "eps_max", "energy_error_j"] {
            assert_eq!(by_key[key], row[key], "{name}: {key}");
            assert_eq!(by_option[key], row[key], "{name}: {key}");
        }
    }
    let behind = ["--set", "compensation.kind=paper+afp"];
    let paper = json(&[&["run", TABLE1][..], &behind, &duration].concat());
    let alone = rows.iter().find(|r| r["compensation"] == "paper").unwrap();
    let error = |r: &Value| r["eps_rms"].as_f64().unwrap();
    assert!(error(&paper) < 0.5 * error(alone));
    for (assignment, words) in [
        (
            "compensation.kind=paper+magic",
            ["paper+magic", "tangent+ats"],
        ),
        ("compensation.adaptation.magic=1", ["adaptation", "magic"]),
        ("compensation.order=4", ["compensation.order", "1 to 3"]),
    ] {
        refused(&["run", TABLE1, "--set", assignment], &words);
    }
}

#[test]
fn many_rigs_differ_and_repeat_themselves() {
    let many = [
        "monte-carlo",
        TABLE1,
        "--tests",
        "20",
        "--duration",
        "6",
        "--json",
    ];
    let (once, again) = (json(&many), json(&many));
    for key in ["completed", "eps_rms_median", "eps_rms_95", "eps_rms_worst"] {
        assert_eq!(once[key], again[key], "{key}");
    }
    let drawn = [
        "sweep",
        TABLE1,
        "--drawn",
        "20",
        "--duration",
        "6",
        "--json",
    ];
    assert_eq!(
        json(&drawn)["eps_rms_95"],
        once["eps_rms_95"],
        "the same by its other name"
    );
    // The damping sees a stiffness in gains of 2 % and does not remove their effect; the tangent force does.
    let tangent = json(&[&many[..], &["--compensation", "tangent"]].concat());
    let of = |a: &Value, key: &str| a[key].as_f64().unwrap();
    for all in [&once, &tangent] {
        assert_eq!(all["completed"], 20);
        assert!(of(all, "eps_rms_median") < of(all, "eps_rms_worst"));
    }
    assert!(of(&tangent, "eps_rms_worst") < 1e-3);
    assert!(of(&once, "eps_rms_95") > 50.0 * of(&tangent, "eps_rms_95"));
    refused(
        &["monte-carlo", TABLE1, "--tests", "0"],
        &["--tests 0", "1 to"],
    );
}
