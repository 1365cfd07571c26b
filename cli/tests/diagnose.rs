//! `outerloop diagnose` as people and scripts call it, on records of tests that it ran itself.
#![allow(missing_docs)]

use serde_json::Value;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const TEST: &str = r#"
[structure]
mass_kg = 1000
stiffness_n_per_m = 158e3
damping_ratio = 0.02
[loop]
rate_hz = 1000
[compensation]
window_steps = 10
[excitation]
duration_s = 20
rest_s = 1.5
[plant.actuator]
kind = "delay"
delay_ms = 4
[plant.sensors]
displacement_noise_mm = 0.02
force_noise_n = 5
"#;

const MODEL: &str = "
[actuator]
gain = { value = 1, tolerance = 0.01 }
delay_ms = { value = 4, tolerance = 0.5 }
offset_mm = { value = 0, tolerance = 0.05 }
[specimen]
stiffness_n_per_mm = { value = 158, tolerance = 2 }
mass_kg = { value = 0, tolerance = 0.1 }
offset_n = { value = 0, tolerance = 20 }
";

const INERTIA: &str = "[[plant.effects]]\nname = \"inertia_force\"\nmass_kg = 60\n";

fn outerloop(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .args(arguments)
        .output()
        .unwrap()
}

/// A folder with a model, and a record of a test on a rig with `effect`.
struct Laboratory {
    folder: tempfile::TempDir,
}

impl Laboratory {
    fn with(effect: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let here = Self { folder };
        here.write("test.toml", &format!("{TEST}{effect}"));
        here.write("model.toml", MODEL);
        let (test, out) = (here.path("test.toml"), here.path("out"));
        let run = outerloop(&["run", &test, "--out", &out]);
        // 1: what nobody declared makes the test wrong, which is what its record is for.
        let code = run.status.code();
        assert!(
            matches!(code, Some(0 | 1)),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        here
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.path().join(name), text).unwrap();
    }

    fn record(&self) -> String {
        self.path("out/record.csv")
    }

    /// `model` on the first and the last part of `record`.
    fn halves(&self, model: &str, record: &str, more: &[&str]) -> Output {
        let (train, test) = (format!("{record}@0..11"), format!("{record}@11.001..21.4"));
        let mut arguments = vec![
            "diagnose", "--model", model, "--train", &train, "--test", &test,
        ];
        arguments.extend(more);
        outerloop(&arguments)
    }

    fn diagnose(&self, model: &str, record: &str) -> Value {
        let output = self.halves(model, record, &["--json"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else")
    }

    /// Refused with exit status 2 and one sentence that says all of `words`.
    #[track_caller]
    fn refused(&self, model: &str, train: &str, test: &str, more: &[&str], words: &[&str]) {
        let saved = self.path("saved.toml");
        let mut arguments = vec![
            "diagnose", "--model", model, "--train", train, "--test", test,
        ];
        arguments.extend(["--json", "--save-model", &saved]);
        arguments.extend(more);
        let output = outerloop(&arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(output.stdout.is_empty());
        assert!(!Path::new(&saved).exists());
        for word in words {
            assert!(said.contains(word), "`{word}` is not in: {said}");
        }
    }

    /// Time, command, displacement and force of the record, changed row by row, as a new file.
    fn changed(&self, name: &str, change: impl Fn(usize, &mut [String; 4])) -> String {
        let text = std::fs::read_to_string(self.record()).unwrap();
        let mut new = String::from("time_s,command_m,displacement_m,force_n\n");
        for (i, line) in text.lines().skip(1).enumerate() {
            let mut row: [String; 4] = Default::default();
            for (to, from) in row.iter_mut().zip(line.split(',')) {
                from.clone_into(to);
            }
            change(i, &mut row);
            let _ = writeln!(new, "{}", row.join(","));
        }
        self.write(name, &new);
        self.path(name)
    }
}

fn channel<'a>(d: &'a Value, name: &str) -> &'a Value {
    let channels = d["channels"].as_array().unwrap();
    channels.iter().find(|c| c["channel"] == name).unwrap()
}

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
        "error_before",
        "error_after",
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
    // It goes on with records of its own kind, and not with others.
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
        &["nothing is recorded from 4.999 s to 7 s"],
        &|i, row| {
            let t: f64 = row[0].parse().unwrap();
            row[0] = (t + if i >= 5000 { 2.0 } else { 0.0 }).to_string();
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
    why(&rail, "specimen", "the input of the specimen is clipped");
    let cut = lab.changed("cut.csv", |_, row| {
        let f: f64 = row[3].parse().unwrap();
        row[3] = f.clamp(-3000.0, 3000.0).to_string();
    });
    why(&cut, "specimen", "the output of the specimen is clipped");
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
    // A rest that is missing is no reason to refuse.
    assert_eq!(c["effects"][0]["name"], "inertia_force", "{c}");
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
