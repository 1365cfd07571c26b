//! Data and models that cannot be judged: refused in one sentence, or not assessed with the reason.

use super::laboratory::{INERTIA, Laboratory, MODEL, channel, outerloop};
use serde_json::Value;

#[test]
fn bad_data_is_refused_with_its_place() {
    let lab = Laboratory::with("");
    let (model, record) = (lab.path("model.toml"), lab.record());
    let span = |part: &str| format!("{record}@{part}");
    let sound = span("11.001..21.4");
    let say = |train: &str, test: &str, words: &[&str]| {
        lab.refused(&model, train, test, &[], words);
    };
    say(&span("0..12"), &sound, &["overlap"]);
    say(
        &span("0..40"),
        &sound,
        &["0..40 s is not inside the record", "21.499"],
    );
    say(
        &span("0..0.1"),
        &sound,
        &["100 samples of training data are too few"],
    );
    say(&span("5..2"), &sound, &["5 s is not below 2 s"]);
    say("nowhere.csv", &sound, &["nowhere.csv", "cannot be read"]);
    let moving = span("3..4");
    lab.refused(
        &model,
        &span("0..11"),
        &sound,
        &["--rest", &moving],
        &["3 s to 3.999 s", "rest"],
    );

    let whole = |name: &str, change: &dyn Fn(usize, &mut [String; 4])| {
        let file = lab.changed(name, change);
        (format!("{file}@0..11"), format!("{file}@11.001..21.4"))
    };
    let change = |name: &str, words: &[&str], change: &dyn Fn(usize, &mut [String; 4])| {
        let (train, test) = whole(name, change);
        say(&train, &test, words);
    };
    change("nan.csv", &["line 702", "force_n is `nan`"], &|i, row| {
        if i == 700 {
            row[3] = "nan".into();
        }
    });
    change("text.csv", &["line 702", "`high`"], &|i, row| {
        if i == 700 {
            row[2] = "high".into();
        }
    });
    change(
        "back.csv",
        &["line 702", "0.6 s follows on 0.699"],
        &|i, row| {
            if i == 700 {
                row[0] = "0.6".into();
            }
        },
    );
    change(
        "gap.csv",
        &[
            "nothing was recorded from 4.999 s to 8 s (3000 rows)",
            "at most 20.0 % is missing",
        ],
        &|i, row| {
            let t: f64 = row[0].parse().unwrap();
            row[0] = (t + if i >= 5000 { 3.0 } else { 0.0 }).to_string();
        },
    );
    change("swapped.csv", &["swapped"], &|_, row| row.swap(2, 3));
    change(
        "unit.csv",
        &["displacement", "units of its header"],
        &|_, row| {
            let x: f64 = row[2].parse().unwrap();
            row[2] = (1e-3 * x).to_string();
        },
    );
    change("metres.csv", &["20 m", "is the unit right?"], &|_, row| {
        let x: f64 = row[2].parse().unwrap();
        row[2] = (1e3 * x).to_string();
    });
    let times = |text: &mut String, factor: f64| {
        *text = (factor * text.parse::<f64>().unwrap()).to_string();
    };
    change(
        "kilonewton.csv",
        &["force per displacement is 1.000e-3", "units of its header"],
        &|_, row| times(&mut row[3], 1e-3),
    );
    change(
        "command.csv",
        &["displacement per command is 1.000e3", "units of its header"],
        &|_, row| times(&mut row[1], 1e-3),
    );
    change(
        "early.csv",
        &["displacement goes before the command by 4.0 ms", "swapped"],
        &|_, row| row.swap(1, 2),
    );
    change(
        "sign.csv",
        &["force falls where displacement rises"],
        &|_, row| times(&mut row[3], -1.0),
    );
    change(
        "infinite.csv",
        &["line 702", "force_n is `inf`"],
        &|i, row| {
            if i == 700 {
                row[3] = "inf".into();
            }
        },
    );
    change(
        "hole.csv",
        &["line 702", "displacement_m is ``"],
        &|i, row| {
            if i == 700 {
                row[2].clear();
            }
        },
    );
    change(
        "stuck.csv",
        &["force follows the command and displacement does not"],
        &|_, row| row[2] = "0.001".into(),
    );
    let copy = lab.changed("copy.csv", |_, _| ());
    say(&record, &copy, &["same samples"]);
    let text = std::fs::read_to_string(&copy).unwrap();
    for (header, words) in [
        (
            "time_s,command_m,displacement_m,force_mm",
            "`force_mm` is refused",
        ),
        ("time_s,command_m,command_mm,force_n", "stands twice"),
        ("command_m,displacement_m,force_n,run", "has no time"),
    ] {
        let (_, rows) = text.split_once('\n').unwrap();
        lab.write("header.csv", &format!("{header}\n{rows}"));
        let file = lab.path("header.csv");
        say(&file, &record, &["line 1", words]);
    }
}

#[test]
fn a_bad_model_is_refused_with_its_line() {
    let lab = Laboratory::with("");
    let record = lab.record();
    let (train, test) = (format!("{record}@0..11"), format!("{record}@11.001..21.4"));
    for (from, to, words) in [
        ("gain", "gian", &["line 3", "gian"][..]),
        (
            "tolerance = 2 ",
            "tolerance = -2 ",
            &["stiffness_n_per_mm.tolerance = -2"],
        ),
        ("tolerance = 2 ", "tolerance = inf ", &["tolerance = inf"]),
        ("value = 4", "value = -4", &["actuator.delay_ms.value = -4"]),
        ("value = 158", "value = \"stiff\"", &["line 7"]),
        (MODEL, "", &["declares no channel"]),
    ] {
        lab.write("bad.toml", &MODEL.replace(from, to));
        let mut all = vec!["bad.toml"];
        all.extend(words);
        lab.refused(&lab.path("bad.toml"), &train, &test, &[], &all);
    }
}

#[test]
fn what_cannot_be_judged_is_not_assessed_and_says_why() {
    let lab = Laboratory::with(INERTIA);
    let model = lab.path("model.toml");
    let why = |file: &str, name: &str, words: &str| {
        let d = lab.diagnose(&model, file);
        let c = channel(&d, name);
        assert_eq!(c["verdict"], "not_assessed", "{c}");
        // What was not computed is null, not 0.
        assert!(c["error_before"]["test_rms"].is_null(), "{c}");
        assert!(c["noise_floor_rms"].is_null(), "{c}");
        let notes = c["notes"].to_string();
        assert!(notes.contains(words), "`{words}` is not in {notes}");
    };
    let still = lab.changed("still.csv", |_, row| row[3] = "12.5".into());
    why(&still, "specimen", "stands still at 12.5");
    let parked = lab.changed("parked.csv", |_, row| row[1] = "0.001".into());
    why(&parked, "actuator", "stands still at 1");
    let rail = lab.changed("rail.csv", |_, row| {
        let x: f64 = row[2].parse().unwrap();
        row[2] = x.clamp(-0.03, 0.03).to_string();
    });
    why(
        &rail,
        "specimen",
        "the displacement of the specimen is clipped: it stays at its",
    );
    let cut = lab.changed("cut.csv", |_, row| {
        let f: f64 = row[3].parse().unwrap();
        row[3] = f.clamp(-3000.0, 3000.0).to_string();
    });
    why(
        &cut,
        "specimen",
        "the force of the specimen is clipped: it stays at its",
    );
    let text = std::fs::read_to_string(&still).unwrap();
    lab.write("nocommand.csv", &text.replacen("command_m", "oil_c", 1));
    why(&lab.path("nocommand.csv"), "actuator", "missing");

    let record = lab.record();
    let (train, test) = (format!("{record}@3..11"), format!("{record}@11.001..21.4"));
    let output = outerloop(&[
        "diagnose", "--model", &model, "--train", &train, "--test", &test, "--json",
    ]);
    let d: Value = serde_json::from_slice(&output.stdout).unwrap();
    let c = channel(&d, "specimen");
    // A missing rest is no reason to refuse.
    assert_eq!(c["effects"][0]["name"], "inertia_force", "{c}");
}
