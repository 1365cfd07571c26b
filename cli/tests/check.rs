//! `outerloop check` on the command line.
#![allow(missing_docs)]

use serde_json::Value;
use std::process::{Command, Output};

fn check(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .arg("check")
        .arg(concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../examples/table1.toml"
        ))
        .args(arguments)
        .output()
        .expect("the tool runs")
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).expect("one JSON object")
}

#[test]
fn a_test_that_cannot_be_stable_is_refused_with_the_published_limit() {
    let output = check(&["--compensation", "none", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8_lossy(&output.stderr);
    for word in [
        "cannot be stable",
        "4.00 ms late",
        "a delay below 3.18",
        "paper",
    ] {
        assert!(said.contains(word), "{word} is not in: {said}");
    }
    let answer = json(&output);
    assert_eq!(answer["stable"], false);
    // Growth and limit of the audit: 6.65 % a second, 2 zeta / omega = 3.18 ms, by the time scale as well.
    let growth = answer["growth_per_s"].as_f64().unwrap().exp_m1();
    assert!((growth - 0.0665).abs() < 2e-4, "{growth}");
    let limit = answer["delay"]["limit"].as_f64().unwrap();
    assert!((limit - 3.183).abs() < 0.01, "{limit}");
    let needed = answer["time_scale_needed"].as_f64().unwrap();
    assert!((needed - 4.0 / 3.183).abs() < 0.01, "{needed}");
    assert!(answer["perturbed"]["unstable"].as_u64().unwrap() > 100);
}

#[test]
fn the_default_compensation_is_stable_and_its_budget_adds_up() {
    let output = check(&["--json", "--plants", "20"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let answer = json(&output);
    assert_eq!(answer["stable"], true);
    assert_eq!(answer["reason"], Value::Null);
    let parts = answer["delay_budget"].as_array().unwrap();
    let sum: f64 = parts
        .iter()
        .filter(|p| {
            !p["from"]
                .as_str()
                .unwrap()
                .contains("not in the eigenvalues")
        })
        .map(|p| p["ms"].as_f64().unwrap())
        .sum();
    assert!((sum - 4.0).abs() < 1e-6, "{sum}");
    assert_eq!(answer["perturbed"]["spread"]["plants"], 20);
    assert_eq!(json(&check(&["--json", "--plants", "20"])), answer);
}

#[test]
fn bad_input_is_refused_in_one_sentence() {
    for (arguments, said) in [
        (
            &["--plants", "0"][..],
            "--plants 0: accepted are 1 to 100000",
        ),
        (&["--delay-spread", "200"], "--delay-spread 200"),
        (&["--compensation", "magic"], "magic"),
        (&["--set", "plant.actuator.gain=0"], "plant.actuator.gain"),
    ] {
        let output = check(arguments);
        assert_eq!(output.status.code(), Some(2));
        assert!(output.stdout.is_empty());
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(
            text.contains(said) && text.trim().lines().count() == 1,
            "{text}"
        );
    }
}
