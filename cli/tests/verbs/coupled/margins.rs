//! Verdict and margins of `check`.

use super::EXAMPLE;
use crate::common::{json, json_with, outerloop};

#[test]
fn check_says_what_the_limits_leave() {
    let arguments = ["check", EXAMPLE, "--plants", "4", "--json"];
    let said = json(&arguments);
    assert_eq!(said["verdict"], "stable", "{}", said["reason"]);
    assert!(said["expected_eps_rms"].as_f64().unwrap() < 0.02);
    let tight = [&arguments[..], &["--set", "coupled.limits.x_m=0.0175"]].concat();
    let said = json_with(1, &tight);
    assert_eq!(said["verdict"], "doubtful", "{}", said["reason"]);
    let wrong = [&arguments[..], &["--compensation", "none"]].concat();
    assert_eq!(json_with(2, &wrong)["verdict"], "unstable");
}

/// A margin ends where a rig that is as much later or stronger makes the planned motion poor, and knowing more of the actuators
/// leaves more of it.
#[test]
fn the_margins_of_a_check_are_where_the_planned_motion_becomes_poor() {
    let duration = ["--set", "excitation.duration_s=8"];
    // The poles as they are, so that the motion is good without learning, too.
    let poles = ["--set", "coupled.actuators.slow_pole_hz=[2.8,3.3]"];
    let margins = |compensation: &str, more: &[&str]| {
        let check = ["check", EXAMPLE, "--plants", "1", "--json"];
        let of = ["--compensation", compensation];
        let said = outerloop(&[&check[..], &of, &duration, more].concat());
        let said: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
        ["delay", "gain"].map(|name| {
            let found = |key: &str| said["margins"][name][key].as_f64().unwrap();
            (found("present"), found("limit"))
        })
    };
    let [delay, gain] = margins("coupled", &[]);
    println!("{delay:?} {gain:?}");
    assert_eq!((delay.0, gain.0), (2.0, 1.0));
    let poor = |keys: [String; 2]| {
        let [first, second] = keys.each_ref().map(String::as_str);
        let run = ["run", EXAMPLE, "--json", "--set", first, "--set", second];
        let said = outerloop(&[&run[..], &duration].concat());
        let said: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
        said["verdict"] != "completed" || said["eps_rms"].as_f64().unwrap() > 0.1
    };
    let rig = |ms: f64, factor: f64| {
        let [a, b, c, d] = [0.88, 0.128, 0.143, 0.91].map(|gain| factor * gain);
        poor([
            format!("plant.coupled.actuators.delay_ms=[{ms},{ms}]"),
            format!("plant.coupled.actuators.gain=[[{a},{b}],[{c},{d}]]"),
        ])
    };
    assert!(!rig(2.0 + 0.95 * (delay.1 - 2.0), 1.0));
    assert!(rig(2.0 + 1.05 * (delay.1 - 2.0), 1.0));
    assert!(!rig(2.0, 1.0 + 0.95 * (gain.1 - 1.0)));
    assert!(rig(2.0, 1.0 + 1.05 * (gain.1 - 1.0)));
    let fixed = margins("coupled-fixed", &poles);
    assert!(fixed[0].1 < delay.1 && fixed[1].1 < gain.1, "{fixed:?}");
}

/// The margins of a check with these keys, and what the terminal says.
fn margins_with(keys: &[&str]) -> (serde_json::Value, String) {
    let duration = [
        "check",
        EXAMPLE,
        "--plants",
        "1",
        "--set",
        "excitation.duration_s=8",
    ];
    let check = [&duration[..], keys].concat();
    let said = outerloop(&[&check[..], &["--json"]].concat());
    let said: serde_json::Value = serde_json::from_slice(&said.stdout).unwrap();
    let text = String::from_utf8(outerloop(&check).stdout).unwrap();
    let words: Vec<&str> = text.split_whitespace().collect();
    (said, words.join(" "))
}

/// An unstable motion has no margins, nor has one that is poor on the rig as it is.
#[test]
fn a_test_that_is_lost_or_poor_as_it_is_has_no_margins() {
    let late = "plant.coupled.actuators.delay_ms=[40,40]";
    for (keys, verdict, why) in [
        (["--set", late], "unstable", "the test is unstable"),
        (
            ["--compensation", "uncoupled"],
            "doubtful",
            "the planned motion is poor on the rig as it is",
        ),
    ] {
        let (answer, text) = margins_with(&keys);
        assert_eq!(answer["verdict"], verdict, "{keys:?}");
        for name in ["delay", "gain"] {
            let margin = &answer["margins"][name];
            assert_eq!(margin["search"], "no_margin", "{keys:?}: {margin}");
            assert_eq!(margin["why"], why, "{keys:?}: {margin}");
            assert!(margin["limit"].is_null(), "{keys:?}: {margin}");
        }
        assert!(
            text.contains(&format!("There are no margins: {why}.")),
            "{text}"
        );
        assert!(!text.contains("0.0 %"), "{text}");
    }
}

/// Gains of up to 91 may not grow by a third, as those of the example: 100 is the largest that a rig may have.
#[test]
fn a_margin_of_coupled_actuators_ends_at_a_rig_that_is_refused() {
    let declared = "coupled.actuators.gain=[[86.4,13.1],[14.0,92.7]]";
    let rig = "plant.coupled.actuators.gain=[[88,12.8],[14.3,91]]";
    let (answer, text) = margins_with(&["--set", declared, "--set", rig]);
    let gain = &answer["margins"]["gain"];
    assert_eq!(gain["search"], "refused", "{gain}");
    let searched = gain["searched_to"].as_f64().unwrap();
    assert!((1.09..100.0 / 91.0).contains(&searched), "{searched}");
    let delay = &answer["margins"]["delay"];
    assert_eq!(delay["search"], "found", "{delay}");
    for words in [
        "none up to 1.09",
        "ended at a refusal: plant.coupled.actuators.gain is 100.",
        "the loop does not know of it and keeps its parameters",
    ] {
        assert!(text.contains(words), "{words} is not in: {text}");
    }
}
