//! `outerloop diagnose` as people and scripts call it, on records of tests run here.

mod beside;
mod laboratory;
mod refusals;

use laboratory::{INERTIA, Laboratory, channel, outerloop};
use serde_json::Value;
use std::path::{Path, PathBuf};

#[test]
fn an_undeclared_mass_is_found_saved_and_then_nothing_is_missing() {
    let lab = Laboratory::with(INERTIA);
    let d = lab.diagnose(&lab.path("model.toml"), &lab.record());
    assert_eq!(channel(&d, "actuator")["verdict"], "none");
    let s = channel(&d, "specimen");
    for key in [
        "verdict",
        "effects",
        "alternatives",
        "nearest",
        "noise_floor_rms",
        "unit",
        "error_declared",
        "error_before",
        "error_after",
        "unnamed",
        "members",
        "improvement_ci90",
        "notes",
    ] {
        assert!(s.get(key).is_some(), "{key}");
    }
    assert_eq!((&s["verdict"], &s["unit"]), (&"effect".into(), &"N".into()));
    let effect = &s["effects"][0];
    assert_eq!(
        (&effect["name"], &effect["family"]),
        (&"inertia_force".into(), &"inertia".into())
    );
    assert!(effect["p"].as_f64().is_some_and(|p| p > 0.9), "{effect}");
    for refitted in s["refitted"].as_array().unwrap() {
        let ci90 = refitted["ci90"].as_array().unwrap();
        assert!(ci90[0].as_f64() < ci90[1].as_f64(), "{refitted}");
    }
    let mass = &effect["parameters"][0];
    assert!(
        (mass["value"].as_f64().unwrap() - 60.0).abs() < 2.0,
        "{mass}"
    );
    let rms = |which: &str| s[which]["test_rms"].as_f64().unwrap();
    assert!(rms("error_after") < 0.7 * rms("error_before"));

    let (out, model) = (lab.path("report"), lab.path("improved.toml"));
    let saved = ["--out", out.as_str(), "--save-model", model.as_str()];
    let told = lab.halves(&lab.path("model.toml"), &lab.record(), &saved);
    let told = String::from_utf8_lossy(&told.stdout);
    assert!(
        told.contains("The specimen model lacks inertia_force"),
        "{told}"
    );
    let page = std::fs::read_to_string(PathBuf::from(&out).join("report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("inertia_force") && !page.contains("src="));
    let again = lab.diagnose(&model, &lab.record());
    assert_eq!(channel(&again, "specimen")["verdict"], "none");
}

#[test]
fn nothing_is_missing_where_nothing_was_added() {
    let lab = Laboratory::with("");
    let d = lab.diagnose(&lab.path("model.toml"), &lab.record());
    for name in ["actuator", "specimen"] {
        let c = channel(&d, name);
        assert_eq!(c["verdict"], "none", "{c}");
        assert_eq!(c["error_before"], c["error_after"]);
        assert!(c["effects"].as_array().unwrap().is_empty());
    }
    let origin = &d["provenance"];
    assert_eq!(origin["files"].as_array().unwrap().len(), 2, "{origin}");
    assert!(
        origin["command"]
            .as_str()
            .unwrap()
            .starts_with("outerloop diagnose")
    );
}

#[test]
fn a_model_of_a_force_without_a_unit_says_so_and_is_not_taken_for_newtons() {
    let lab = Laboratory::with(INERTIA);
    let record = lab.changed("plain.csv", |_, _| {});
    let text = std::fs::read_to_string(&record).unwrap();
    lab.write("plain.csv", &text.replacen("force_n", "force_1", 1));
    let (declared, model) = (lab.path("model.toml"), lab.path("without.toml"));
    let done = lab.halves(&declared, &record, &["--save-model", &model]);
    assert!(done.status.success(), "{done:?}");
    let saved = std::fs::read_to_string(&model).unwrap();
    assert!(saved.contains("force_unit = \"1\""), "{saved}");
    assert!(saved.contains("mass_kg]\nvalue = 60."), "{saved}");
    // It works with records of its own kind, and with no others.
    let again = lab.diagnose(&model, &record);
    assert_eq!(channel(&again, "specimen")["verdict"], "none");
    let newtons = lab.record();
    let (train, test) = (
        format!("{newtons}@0..11"),
        format!("{newtons}@11.001..21.4"),
    );
    lab.refused(
        &model,
        &train,
        &test,
        &[],
        &["specimen.force_unit", "in newtons"],
    );
    let run = outerloop(&["run", &lab.path("test.toml"), "--model", &model]);
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(
        said.contains("nothing of its specimen is taken into account"),
        "{said}"
    );
    assert!(!said.contains("inertia of"), "{said}");
}

#[test]
fn uneven_time_is_laid_on_a_grid_and_that_is_said() {
    let lab = Laboratory::with("");
    let jitter = lab.changed("jitter.csv", |i, row| {
        let t: f64 = row[0].parse().unwrap();
        row[0] = (t + if i % 2 == 0 { 2e-4 } else { 0.0 }).to_string();
    });
    let told = lab.halves(&lab.path("model.toml"), &jitter, &[]);
    let told = String::from_utf8_lossy(&told.stdout);
    let told = told.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(
        told.contains("time stamps lie 0.800 to 1.200 ms apart"),
        "{told}"
    );
}

#[test]
fn the_next_test_is_designed_written_played_and_diagnosed_beside_the_first() {
    let lab = Laboratory::with("[[plant.effects]]\nname = \"second_lag\"\nlag_ms = 5\n");
    let (model, next, test) = (
        lab.path("model.toml"),
        lab.path("next.csv"),
        lab.path("test.toml"),
    );
    let (record, second) = (lab.record(), lab.path("second"));
    let (train, held_out) = (format!("{record}@..12"), format!("{record}@12..21"));
    let ask = |more: &[&str]| {
        let mut arguments = vec!["diagnose", "--json", "--model", &model, "--train", &train];
        arguments.extend(more);
        arguments.extend(["--test", &held_out]);
        let output = outerloop(&arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        serde_json::from_slice::<Value>(&output.stdout).unwrap()
    };
    let first = ask(&["--next", &next]);
    let plan = &first["next"];
    assert_eq!(plan["file"], next.as_str());
    assert_eq!(plan["limits"]["velocity_from"], "record");
    assert!(plan["seconds"].as_f64().unwrap() > 8.0, "{plan:#}");
    assert!(
        !plan["channels"][0]["candidates"]
            .as_array()
            .unwrap()
            .is_empty()
    );
    let written = std::fs::read_to_string(&next).unwrap();
    assert!(
        written.contains("\ntime_s,command_mm\n0.000000,0.000000\n"),
        "{}",
        &written[..300]
    );

    let played = outerloop(&["run", &test, "--signal", &next, "--out", &second, "--json"]);
    let said = String::from_utf8_lossy(&played.stderr);
    assert!(played.status.success(), "{said}");
    let told: Value = serde_json::from_slice(&played.stdout).unwrap();
    assert_eq!(told["verdict"], "completed");
    let page = std::fs::read_to_string(format!("{second}/report.html")).unwrap();
    assert!(page.contains("Where the specimen was to be"));
    let record = format!("{second}/record.csv");
    let both = ask(&["--train", &record]);
    let actuator = &both["channels"][0];
    let names = actuator["effects"].as_array().unwrap();
    assert!(
        names.iter().any(|e| e["family"] == "timing"),
        "{actuator:#}"
    );

    // Beyond a limit nothing moves and nothing is written.
    let third = lab.path("third");
    let limit = "limits.displacement_m=1e-4";
    let refused = outerloop(&[
        "run", &test, "--signal", &next, "--out", &third, "--set", limit,
    ]);
    assert_eq!(refused.status.code(), Some(2));
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(said.contains("limits.displacement_m = 0.0001"), "{said}");
    assert!(!Path::new(&third).exists());
}
