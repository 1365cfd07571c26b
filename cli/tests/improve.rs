//! `outerloop improve`: what a diagnosis finds makes the next test better, by the error of the test itself.
#![allow(missing_docs)]

use serde_json::Value;
use std::path::Path;
use std::process::Command;

fn improve(arguments: &[&str]) -> Vec<Value> {
    let output = Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .arg("improve")
        .args(arguments)
        .arg("--json")
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    serde_json::from_slice(&output.stdout).expect("one JSON array and nothing else")
}

#[test]
fn the_next_test_is_nearly_as_good_as_without_the_effect() {
    for (name, effect, best) in [
        ("inertia", "inertia_force", 1.3),
        ("calibration", "gain_error", 1.3),
        ("friction", "coulomb_friction", 2.0),
        // A lag of 6 ms more is 6 ms more to make up for; knowing it does not take it away.
        ("lag", "lag_error", 8.0),
    ] {
        let rows = improve(&[&format!("examples/undeclared/{name}.toml")]);
        let row = &rows[0];
        let eps = |key: &str| row[key].as_f64().unwrap();
        // Found, or said to be as good as what is preferred: a lag behind none that is declared is a second lag too.
        let channels = row["diagnosis"]["channels"].as_array().unwrap();
        let named = |c: &Value| {
            let alternatives = c["alternatives"].as_array().unwrap();
            c["effects"][0]["name"] == effect || alternatives.contains(&effect.into())
        };
        assert!(channels.iter().any(named), "{name}: {}", row["found"]);
        assert_eq!(row["undeclared"], effect);
        assert!(eps("eps_rms_before") > 0.15, "{name}");
        assert!(eps("eps_rms_after") < 0.3 * eps("eps_rms_before"), "{name}");
        assert!(
            eps("eps_rms_after") < best * eps("eps_rms_without_effect"),
            "{name}"
        );
    }
}

#[test]
fn a_rig_that_is_as_declared_is_left_alone() {
    let rows = improve(&[
        "examples/undeclared/inertia.toml",
        "--set",
        "plant.effects=[]",
    ]);
    assert_eq!(rows[0]["found"], "nothing");
    assert!(rows[0]["changes"].as_array().unwrap().is_empty());
    assert_eq!(rows[0]["eps_rms_before"], rows[0]["eps_rms_after"]);
}
