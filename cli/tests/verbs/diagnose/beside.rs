//! Unused channels, and records at different settings of one adjustment, as evidence for a name.

use super::laboratory::{Laboratory, channel, outerloop};
use serde_json::Value;
use std::fmt::Write as _;

const FRICTION: &str =
    "[[plant.effects]]\nname = \"coulomb_friction\"\nforce_n = 400\npresliding_mm = 0.1\n";

/// A separate file with the record's time and a channel computed from its displacement, mm, and velocity, mm/s.
fn witness(lab: &Laboratory, name: &str, of: impl Fn(f64, f64) -> f64) -> String {
    let text = std::fs::read_to_string(lab.record()).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |wanted: &str| head.iter().position(|h| *h == wanted).unwrap();
    let (time, x) = (place("time_s"), place("displacement_m"));
    let rows: Vec<[f64; 2]> = lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            [
                cells[time].parse().unwrap(),
                1e3 * cells[x].parse::<f64>().unwrap(),
            ]
        })
        .collect();
    // Over twenty samples, since the reading has noise.
    let speed = |i: usize| {
        let (a, b) = (
            rows[i.saturating_sub(10)],
            rows[(i + 10).min(rows.len() - 1)],
        );
        (b[1] - a[1]) / (b[0] - a[0])
    };
    let mut own = String::from("time_s,oil_bar\n");
    for (i, [t, x]) in rows.iter().enumerate() {
        let _ = writeln!(own, "{t},{:.5}", of(*x, speed(i)));
    }
    lab.write(name, &own);
    lab.path(name)
}

/// The first testimony of the first witness.
fn said(lab: &Laboratory, witness: &str) -> Value {
    let output = lab.halves(
        &lab.path("model.toml"),
        &lab.record(),
        &["--json", "--witness", witness],
    );
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let d: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(
        channel(&d, "specimen")["effects"][0]["name"],
        "coulomb_friction"
    );
    d["witness"][0]["testimonies"][0].clone()
}

#[test]
fn a_pressure_that_turns_over_with_the_speed_speaks_for_friction_and_one_of_the_motion_alone_says_nothing()
 {
    let lab = Laboratory::with(FRICTION);
    let turns_over = |v: f64| (v / 2.0).tanh();
    let oil = witness(&lab, "oil.csv", |x, v| {
        12.0 + 0.3 * x + 0.02 * v + 4.0 * turns_over(v)
    });
    let heard = said(&lab, &format!("{oil}:oil_bar"));
    assert_eq!(
        (&heard["name"], &heard["says"]),
        (&"coulomb_friction".into(), &"for".into()),
        "{heard}"
    );
    assert!(heard["share"].as_f64().unwrap() > 0.5, "{heard}");
    let low = heard["share_ci90"][0].as_f64().unwrap();
    assert!(low > 0.4 && low < heard["share"].as_f64().unwrap());

    // The motion leaves the noise of the reading.
    let motion = witness(&lab, "motion.csv", |x, v| 12.0 + 0.3 * x + 0.02 * v);
    let heard = said(&lab, &format!("{motion}:2"));
    assert_eq!(heard["says"], "nothing", "{heard}");
    let stiffer = witness(&lab, "stiffer.csv", |x, v| {
        0.3 * x + 1e-3 * x.powi(3) + 0.02 * v
    });
    let heard = said(&lab, &format!("{stiffer}:oil_bar"));
    assert_ne!(heard["says"], "for", "{heard}");

    let out = lab.path("page");
    let named = format!("{oil}:oil_bar");
    let told = lab.halves(
        &lab.path("model.toml"),
        &lab.record(),
        &["--witness", &named, "--out", &out],
    );
    let told = String::from_utf8_lossy(&told.stdout);
    assert!(told.contains("`oil_bar` shows coulomb_friction"), "{told}");
    let page = std::fs::read_to_string(format!("{out}/report.html")).unwrap();
    assert!(page.contains("What the motion leaves of") && page.contains("oil_bar"));
}

#[test]
fn a_witness_that_takes_part_or_was_not_there_is_refused() {
    let lab = Laboratory::with("");
    let (model, record) = (lab.path("model.toml"), lab.record());
    let (train, test) = (format!("{record}@0..11"), format!("{record}@11.001..21.4"));
    lab.write(
        "short.csv",
        &format!(
            "time_s,oil_bar\n{}",
            (0..100).fold(String::new(), |s, i| s + &format!("{}.5,{i}\n", i + 100))
        ),
    );
    let short = format!("{}:oil_bar", lab.path("short.csv"));
    for (witness, words) in [
        (
            format!("{record}:displacement_m"),
            &["--witness", "is the displacement", "takes no part"][..],
        ),
        (
            format!("{record}:force_n"),
            &["is the force", "the declared model needs"],
        ),
        (format!("{record}:oil_bar"), &["has no column `oil_bar`"]),
        (
            short,
            &["covers no record of --train", "was recorded meanwhile"],
        ),
    ] {
        lab.refused(&model, &train, &test, &["--witness", &witness], words);
    }
}

#[test]
fn the_friction_follows_the_dial_of_a_brake_and_nothing_else_does() {
    let lab = Laboratory::with(FRICTION);
    let mut arguments: Vec<String> = Vec::new();
    for force_n in ["200", "400", "800"] {
        let own = lab.path(force_n);
        let test = lab.path("test.toml");
        // The only effect of the file, by its index.
        let set = format!("plant.effects.0.force_n={force_n}");
        let run = outerloop(&["run", &test, "--set", &set, "--out", &own]);
        assert!(
            matches!(run.status.code(), Some(0 | 1)),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        arguments.extend(["--dial".into(), format!("{force_n}={own}/record.csv")]);
    }
    let mut given: Vec<&str> = arguments.iter().map(String::as_str).collect();
    given.push("--json");
    let (model, record) = (lab.path("model.toml"), lab.record());
    let output = lab.halves(&model, &record, &given);
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    let d: Value = serde_json::from_slice(&output.stdout).unwrap();
    let turned = &d["dial"][0];
    assert_eq!(turned["name"], "coulomb_friction", "{turned}");
    assert_eq!(turned["doses"], serde_json::json!([200.0, 400.0, 800.0]));
    for n in turned["numbers"].as_array().unwrap() {
        let follows = n["follows"].as_bool().unwrap();
        assert_eq!(
            follows,
            ["force_n", "rms_n"].contains(&n["name"].as_str().unwrap()),
            "{n}"
        );
        if n["name"] == "force_n" {
            for (value, force_n) in n["values"]
                .as_array()
                .unwrap()
                .iter()
                .zip([200.0, 400.0, 800.0])
            {
                assert!(
                    (value.as_f64().unwrap() / force_n - 1.0).abs() < 0.05,
                    "{n}"
                );
            }
        }
    }

    lab.refused(
        &model,
        &format!("{record}@0..11"),
        &format!("{record}@11.001..21.4"),
        &arguments[..4]
            .iter()
            .map(String::as_str)
            .collect::<Vec<_>>(),
        &["--dial", "2 records at 2 settings", "3 settings and more"],
    );
}
