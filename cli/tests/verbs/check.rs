//! `outerloop check` on the command line.

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
    assert_eq!(output.status.code(), Some(2));
    let said = String::from_utf8_lossy(&output.stderr);
    for word in [
        "unstable: with compensation `none` the test cannot be stable",
        "4.00 ms late",
        "the planned motion is good with the compensations",
    ] {
        assert!(said.contains(word), "{word} is not in: {said}");
    }
    let answer = json(&output);
    assert_eq!(answer["stable"], false);
    assert_eq!(answer["verdict"], "unstable");
    // Growth and limit from the audit: 6.65 % a second, 2 zeta / omega = 3.18 ms, and the same from the time scale.
    let growth = answer["growth_per_s"].as_f64().unwrap().exp_m1();
    assert!((growth - 0.0665).abs() < 2e-4, "{growth}");
    let accepted = |before: &str| -> f64 {
        let (_, behind) = said.split_once(before).expect(before);
        let number = behind.split([' ', ',']).next().unwrap();
        number.parse().unwrap()
    };
    let limit = accepted("a delay below ");
    assert!((limit - 3.183).abs() < 0.01, "{limit}");
    let needed = accepted("a time scale of at least ");
    assert!((needed - 4.0 / 3.183).abs() < 0.01, "{needed}");
    assert!(answer["perturbed"]["unstable"].as_u64().unwrap() > 100);
}

#[test]
fn the_default_compensation_is_stable_and_its_budget_adds_up() {
    let output = check(&["--json", "--plants", "20"]);
    assert!(output.status.success() && output.stderr.is_empty());
    let answer = json(&output);
    assert_eq!(answer["stable"], true);
    assert_eq!(answer["verdict"], "stable");
    let expected = answer["expected_eps_rms"].as_f64().unwrap();
    assert!((0.005..0.02).contains(&expected), "{expected}");
    let parts = answer["delay_budget"].as_array().unwrap();
    let sum: f64 = parts
        .iter()
        .filter(|p| !p["from"].as_str().unwrap().contains("not simulated"))
        .map(|p| p["ms"].as_f64().unwrap())
        .sum();
    assert!((sum - 4.0).abs() < 1e-6, "{sum}");
    assert_eq!(answer["perturbed"]["spread"]["plants"], 20);
    let without_date = |mut answer: Value| {
        answer["provenance"].as_object_mut().unwrap().remove("date");
        answer
    };
    let again = json(&check(&["--json", "--plants", "20"]));
    assert_eq!(without_date(again), without_date(answer));
}

#[test]
fn a_runaway_is_never_called_stable_and_a_wrong_result_is_doubtful() {
    // The errors of `run` with the default method, configured with the true delay: 8.5 %, 12 %, and a runaway.
    for (delay_ms, verdict, status, said) in [
        ("12", "stable", 0, "ran to its end"),
        ("15", "doubtful", 1, "not the structure's response"),
        ("40", "unstable", 2, "the planned motion runs away"),
    ] {
        let delay = format!("plant.actuator.delay_ms={delay_ms}");
        let output = check(&["--json", "--plants", "1", "--set", &delay]);
        let answer = json(&output);
        assert_eq!(answer["verdict"], verdict, "{delay_ms} ms");
        assert_eq!(output.status.code(), Some(status), "{delay_ms} ms");
        let reason = answer["reason"].as_str().unwrap();
        assert!(reason.contains(said), "{reason}");
    }
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

fn notes(answer: &Value) -> String {
    answer["notes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|n| n.as_str().unwrap())
        .collect()
}

#[test]
fn a_predictor_that_learns_is_judged_by_what_it_comes_to_and_that_is_said() {
    // Told 1 ms of 8 ms: unstable at the start, stable when it has learnt.
    let learning = |more: &[&str]| {
        let told = ["--compensation", "afp", "--json", "--plants", "20", "--set"];
        let late = [
            "compensation.delay_ms=1",
            "--set",
            "plant.actuator.delay_ms=8",
        ];
        check(&[&told[..], &late, more].concat())
    };
    let output = learning(&[]);
    assert!(output.status.success());
    let answer = json(&output);
    assert_eq!(answer["stable"], true);
    assert_eq!(answer["at_start"]["stable"], false);
    assert!(notes(&answer).contains("the predictor learns"));
    let budget = answer["delay_budget"].as_array().unwrap();
    let predictor = budget.iter().find(|p| p["part"] == "predictor").unwrap();
    assert!((predictor["ms"].as_f64().unwrap() + 8.0).abs() < 0.01);

    // It may learn at most 2 ms: 6 ms remain, and the limit without a predictor is 3.18 ms.
    let bounded = learning(&["--set", "compensation.adaptation.longest_delay_ms=2"]);
    assert_eq!(bounded.status.code(), Some(2));
    let answer = json(&bounded);
    assert_eq!(answer["stable"], false);
    assert_eq!(answer["verdict"], "unstable");
}

/// The verdict is printed first, and no table contradicts it.
#[test]
fn the_verdict_stands_first_and_no_row_promises_what_it_denies() {
    let late = ["--set", "plant.actuator.delay_ms=40", "--plants", "5"];
    let output = check(&late);
    assert_eq!(output.status.code(), Some(2));
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        text.starts_with("UNSTABLE: the planned motion runs away"),
        "{text}"
    );
    let row = |name: &str| {
        let mut rows = text.lines().filter(|l| l.trim_start().starts_with(name));
        rows.next()
            .unwrap_or_else(|| panic!("no row {name} in {text}"))
            .to_owned()
    };
    // Its small motions alone would be stable, but it runs away.
    for learns in ["amb", "ats", "hydraulic"] {
        let row = row(&format!("{learns} "));
        assert!(
            row.contains("not decided") || row.contains("grows"),
            "{row}"
        );
    }
    assert!(row("none ").contains("grows"));
    assert!(!text.contains(" yes ") && !text.contains("eigenvalue"));
    // Bad input has the same exit status, nothing on standard output, and one sentence without this word.
    for form in [&[][..], &["--json"], &["--json", "--quiet"]] {
        let unstable = check(&[&late, form].concat());
        assert_eq!(
            (unstable.status.code(), unstable.stdout.is_empty()),
            (Some(2), false)
        );
        let bad = check(&[&["--set", "plant.actuator.delay_ms=-1"], form].concat());
        assert_eq!((bad.status.code(), bad.stdout.len()), (Some(2), 0));
        let said = String::from_utf8_lossy(&bad.stderr);
        assert!(
            !said.contains("unstable") && said.trim().lines().count() == 1,
            "{said}"
        );
    }
}

#[test]
fn the_limit_of_a_fixed_predictor_is_its_delay_and_what_the_structure_takes() {
    let answer = json(&check(&[
        "--compensation",
        "lagrange",
        "--json",
        "--plants",
        "20",
    ]));
    assert_eq!(
        (&answer["stable"], &answer["at_start"]),
        (&Value::Bool(true), &Value::Null)
    );
    // Told 4 ms: the limit is 4 ms plus 2 zeta / omega = 3.18 ms.
    let limit = answer["delay"]["limit"].as_f64().unwrap();
    assert!((limit - 7.183).abs() < 0.03, "{limit}");
}

fn text(output: &Output) -> String {
    let text = String::from_utf8_lossy(&output.stdout);
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// `tangent` stands half a period of delay, and any gain that a rig may have: neither is without limit.
#[test]
fn a_margin_without_a_limit_says_how_far_it_was_searched_and_which_rig_was_refused() {
    let tangent = ["--compensation", "tangent", "--plants", "2"];
    let answer = json(&check(&[&tangent[..], &["--json"]].concat()));
    let (delay, gain) = (&answer["delay"], &answer["gain"]);
    assert_eq!(delay["search"], "beyond_range");
    let searched = delay["searched_to"].as_f64().unwrap();
    assert!((searched - 254.0).abs() < 1.0, "{searched}");
    assert_eq!(gain["search"], "refused");
    let searched = gain["searched_to"].as_f64().unwrap();
    assert!((9.9..=10.0).contains(&searched), "{searched}");
    assert!(
        gain["why"]
            .as_str()
            .unwrap()
            .contains("plant.actuator.gain")
    );
    assert_eq!(
        (&delay["limit"], &gain["limit"]),
        (&Value::Null, &Value::Null)
    );
    let said = text(&check(&tangent));
    for words in [
        "none up to 25",
        "none up to 9.9",
        "The search over the loop gain ended at a refusal: plant.actuator.gain",
    ] {
        assert!(said.contains(words), "{words} is not in: {said}");
    }
    assert!(!said.contains("none found"), "{said}");
}

#[test]
fn an_unstable_test_has_no_margins() {
    let amb = ["--compensation", "amb"];
    let late = ["--set", "plant.actuator.delay_ms=40"];
    for case in [amb, late] {
        let case = [&case[..], &["--plants", "2"]].concat();
        let output = check(&[&case[..], &["--json"]].concat());
        assert_eq!(output.status.code(), Some(2), "{case:?}");
        let answer = json(&output);
        for name in ["delay", "gain", "time_scale_needed"] {
            let margin = &answer[name];
            assert_eq!(margin["search"], "no_margin", "{case:?}: {margin}");
            assert_eq!(margin["why"], "the test is unstable", "{case:?}: {margin}");
            assert_eq!(margin["limit"], Value::Null, "{case:?}: {margin}");
        }
        let said = text(&check(&case));
        assert!(
            said.contains("There are no margins: the test is unstable."),
            "{said}"
        );
        assert!(
            !said.contains("none found") && !said.contains("limit margin"),
            "{said}"
        );
    }
}

/// The terminal and the page of a check.
fn terminal_and_page(delay_ms: &str) -> [String; 2] {
    let folder = tempfile::tempdir().unwrap();
    let delay = format!("plant.actuator.delay_ms={delay_ms}");
    let out = folder.path().to_str().unwrap();
    let output = check(&["--plants", "2", "--set", &delay, "--out", out]);
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    let page = page.split_whitespace().collect::<Vec<_>>().join(" ");
    [text(&output), page]
}

/// At 20 ms the planned motion has an error of 18.7 %, and small motions decay up to 31 ms.
#[test]
fn margins_of_small_motions_say_that_they_are_of_small_motions() {
    for said in terminal_and_page("20") {
        let words = "of small motions alone: the planned motion may be poor within them";
        assert!(said.contains("54.4 %") && said.contains(words), "{said}");
    }
}

/// At 4 ms the limit is 11.2 ms, and a test that declares 12 ms is stable.
#[test]
fn margins_say_that_the_loop_does_not_know_of_the_change() {
    for said in terminal_and_page("4") {
        let words = "the loop does not know of it and keeps its parameters. A test that declares the change may be stable";
        assert!(said.contains("11.189 ms") && said.contains(words), "{said}");
    }
    let declared = ["--set", "plant.actuator.delay_ms=12", "--plants", "2"];
    assert!(check(&declared).status.success());
}

#[test]
fn a_method_behind_another_predictor_has_both_names() {
    let output = check(&[
        "--compensation",
        "tangent+inverse",
        "--json",
        "--plants",
        "20",
    ]);
    assert_eq!(json(&output)["compensation"], "tangent+inverse");
}

#[test]
fn what_will_be_watchable_is_said_before_the_test_with_its_size() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/rig-watch.toml");
    let outlook = |more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_outerloop"))
            .args(["check", file, "--json", "--plants", "2"])
            .args(more)
            .output();
        json(&output.expect("the tool runs"))["watch"].clone()
    };
    // 40 mm at 1 Hz, an actuator declared to within 0.5 ms: the example's 12 ms can be seen, but nothing below 1 ms.
    let watch = outlook(&[]);
    let all = watch["watchable"].as_array().unwrap();
    let late = all
        .iter()
        .find(|w| w["name"] == "delay_error" && w["side"] == "actuator")
        .expect("a late actuator");
    assert_eq!(late["unit"], "ms");
    let least = late["least"].as_f64().unwrap();
    assert!((1.0..12.0).contains(&least), "{least}");
    // Switched off there is no outlook.
    assert_eq!(outlook(&["--set", "watch.on=false"]), Value::Null);
}
