//! `outerloop keys` and `new`: the page matches the code, and what they write is accepted.

use crate::common::{command, is_as_its_schema_says, json, outerloop, refused, root};
use serde_json::Value;
use std::io::Write;
use std::process::Stdio;

/// An example as a table.
fn example_file(name: &str) -> toml::Table {
    let file = root().join(format!("examples/{name}.toml"));
    std::fs::read_to_string(file).unwrap().parse().unwrap()
}

#[test]
fn the_page_is_what_the_command_prints() {
    let printed = String::from_utf8(outerloop(&["keys", "--markdown"]).stdout).unwrap();
    let page = std::fs::read_to_string(root().join("docs/keys.md")).unwrap();
    assert!(
        printed.trim() == page.trim(),
        "docs/keys.md is not what `outerloop keys --markdown` prints"
    );
}

#[test]
fn every_key_of_every_example_is_listed_and_in_the_schema() {
    let groups = json(&["keys", "--json"]);
    let keys = || {
        groups
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|g| g["keys"].as_array().unwrap())
    };
    let paths: Vec<&str> = keys().map(|k| k["path"].as_str().unwrap()).collect();
    assert!(paths.len() > 90, "{}", paths.len());
    for key in keys() {
        for what in ["meaning", "accepted"] {
            assert!(!key[what].as_str().unwrap().is_empty(), "{key}");
        }
    }
    let schema = json(&["schema", "test"]);
    for example in [
        "table1",
        "steel-frame",
        "three-storey",
        "hybrid",
        "coupled-frame",
        "hydraulic-ram",
    ] {
        let table = example_file(example);
        let mut open: Vec<(String, &toml::Value)> =
            table.iter().map(|(k, v)| (k.clone(), v)).collect();
        while let Some((path, value)) = open.pop() {
            match value {
                toml::Value::Table(t) => {
                    open.extend(t.iter().map(|(k, v)| (format!("{path}.{k}"), v)))
                }
                _ => {
                    assert!(paths.contains(&path.as_str()), "{example}: {path}");
                    let pointer = format!("/properties/{}", path.replace('.', "/properties/"));
                    assert!(schema.pointer(&pointer).is_some(), "{example}: {pointer}");
                }
            }
        }
    }
}

#[test]
fn ranges_defaults_and_names_come_from_the_code() {
    let groups = json(&["keys", "--json"]);
    let key = |path: &str| {
        let all = groups
            .as_array()
            .unwrap()
            .iter()
            .flat_map(|g| g["keys"].as_array().unwrap());
        all.into_iter().find(|k| k["path"] == path).unwrap().clone()
    };
    for (path, unit, default, accepted) in [
        ("loop.rate_hz", "Hz", "2000.0", "10 to 100000 Hz"),
        ("compensation.kind", "", "\"paper\"", "eq14-unguarded"),
        ("plant.actuator.kind", "", "\"ideal\"", "servo_hydraulic"),
        ("plant.actuator.delay_ms", "ms", "0.0", "0 to 1000"),
        ("plant.sensors.bits", "1", "null", "2 to 32"),
        ("excitation.rest_s", "s", "0.0", "0 to 60 s"),
    ] {
        let k = key(path);
        assert_eq!(k["unit"], unit, "{k}");
        assert_eq!(k["default"].as_str().unwrap_or("null"), default, "{k}");
        assert!(k["accepted"].as_str().unwrap().contains(accepted), "{k}");
    }
    refused(&["keys", "no such thing"], &["no such thing"]);
}

#[test]
fn every_answer_is_as_its_schema_says() {
    let folder = tempfile::tempdir().unwrap();
    let inside = |name: &str| folder.path().join(name).display().to_string();
    let model = "[actuator]\ndelay_ms = { value = 3, tolerance = 0.5 }\n\
                 [specimen]\nstiffness_n_per_mm = { value = 158, tolerance = 2 }\n";
    let declared = inside("model.toml");
    std::fs::write(&declared, model).unwrap();
    let (first, second) = (inside("first"), inside("second"));
    let record = format!("{first}/record.csv");
    let (train, test) = (format!("{record}@..9"), format!("{record}@9.."));
    let example = "examples/table1.toml";
    let archive = format!("{first}/record.h5");
    let signal = inside("signal.csv");
    std::fs::write(&signal, "time_s,command_mm\n0,0\n1,2\n2,0\n").unwrap();
    let rows: [(&str, Vec<&str>, &str); 14] = [
        (
            "run",
            vec!["run", example, "--duration", "14", "--out", &first],
            "eps_rms",
        ),
        (
            "run",
            vec![
                "run",
                "examples/coupled-frame.toml",
                "--duration",
                "2",
                "--out",
                &second,
            ],
            "verdict",
        ),
        (
            "compare",
            vec![
                "compare",
                example,
                "--duration",
                "4",
                "--compensations",
                "paper,amb",
            ],
            "rows",
        ),
        ("check", vec!["check", example, "--plants", "2"], "modes"),
        (
            "check-coupled",
            vec!["check", "examples/coupled-frame.toml", "--plants", "1"],
            "lost",
        ),
        (
            "sweep",
            vec![
                "sweep",
                example,
                "--over",
                "excitation.scale=1,2",
                "--duration",
                "4",
            ],
            "path",
        ),
        (
            "monte-carlo",
            vec!["sweep", example, "--drawn", "3", "--duration", "4"],
            "completed",
        ),
        (
            "diagnose",
            vec![
                "diagnose", "--model", &declared, "--train", &train, "--test", &test,
            ],
            "channels",
        ),
        ("identify", vec!["identify", &record], "delay_ms"),
        ("diff", vec!["diff", &first, &first], "channels"),
        ("replay", vec!["replay", &archive], "values_different"),
        ("effects", vec!["effects"], "channels"),
        ("keys", vec!["keys"], "keys"),
        (
            "run-signal",
            vec!["run", example, "--signal", &signal],
            "peak_force_n",
        ),
    ];
    for (schema, arguments, without) in rows {
        let output = outerloop(&[&arguments[..], &["--json"]].concat());
        let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
        is_as_its_schema_says(schema, &answer, without);
    }
    refused(&["schema", "chekc"], &["`chekc` (`check`?)", "monte-carlo"]);
}

#[test]
fn a_test_file_and_a_model_are_as_their_schemas_say() {
    let test = json(&["schema", "test"]);
    let known = jsonschema::validator_for(&test).unwrap();
    let read = |name: &str| serde_json::to_value(example_file(name)).unwrap();
    for example in [
        "table1",
        "steel-frame",
        "three-storey",
        "hybrid",
        "coupled-frame",
        "rig-watch",
    ] {
        let file = read(example);
        let wrong: Vec<String> = known
            .iter_errors(&file)
            .map(|e| format!("{}: {e}", e.instance_path()))
            .collect();
        assert!(wrong.is_empty(), "{example}: {wrong:#?}");
    }
    let mut file = read("table1");
    file["loop"]["rate"] = 2000.into();
    assert!(!known.is_valid(&file), "an unknown key");
    let mut file = read("table1");
    file["plant"]["actuator"]["kind"] = "delayed".into();
    assert!(!known.is_valid(&file), "an unknown name");
    let model = json(&["schema", "model"]);
    let known = jsonschema::validator_for(&model).unwrap();
    let declared = read("rig-watch")["declared"].clone();
    assert!(declared["actuator"].is_object() && known.is_valid(&declared));
    let own = serde_json::json!({ "actuator": { "delay_ms": { "value": 4.0, "tolerance": 1.0 } } });
    assert!(known.is_valid(&own));
    assert!(!known.is_valid(&serde_json::json!({ "actuator": { "delay_ms": 4.0 } })));
}

#[test]
fn a_new_test_file_runs() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mine.toml").display().to_string();
    let mut asks = command(&["new", &file])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    asks.stdin
        .take()
        .unwrap()
        .write_all(b"1\n2 t\nfoo\n300 N\n300 N/mm\n3\n6\n\n50\n10\nno-such.at2\n\n")
        .unwrap();
    let output = asks.wait_with_output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success() && said.contains("Mass of a floor"),
        "{said}"
    );
    // A wrong answer is asked for again: a word, another quantity, a file that does not exist.
    assert_eq!(said.matches("Once more:").count(), 3, "{said}");
    let written = std::fs::read_to_string(&file).unwrap();
    for line in ["mass_kg = 2000", "stiffness_n_per_m = 300000"] {
        assert!(written.contains(line), "{line}: {written}");
    }
    let r = json(&["run", &file, "--json"]);
    assert_eq!(r["verdict"], "completed", "{r}");
    refused(&["new", &file], &["is there already"]);
    let copy = folder.path().join("copy.toml").display().to_string();
    assert!(
        outerloop(&["new", &copy, "--from", "hybrid"])
            .status
            .success()
    );
    assert_eq!(
        json(&["run", &copy, "--json", "--duration", "5"])["verdict"],
        "completed"
    );
}

#[test]
fn a_new_signal_takes_units_and_the_band_as_the_documents_write_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("multisine.csv").display().to_string();
    let signal = ["new", "--signal", &file, "--shape", "odd-multisine"];
    for (option, value, said) in [
        ("--peak-mm", "4 N", "`4 N` is refused"),
        ("--peak-mm", "four", "`four` is no number"),
        ("--band-hz", "10", "`10` is no band"),
        ("--band-hz", "10,0.2", "two frequencies that rise"),
    ] {
        refused(&[&signal[..], &[option, value]].concat(), &[said]);
    }
    let good = [
        "--peak-mm",
        "0.4 cm",
        "--band-hz",
        "0.3,8 Hz",
        "--seconds",
        "40",
    ];
    assert!(outerloop(&[&signal[..], &good].concat()).status.success());
    let text = std::fs::read_to_string(&file).unwrap();
    let command_mm = |row: &str| row.split(',').nth(1).unwrap().parse::<f64>().unwrap();
    let largest = text
        .lines()
        .filter(|row| row.starts_with(|c: char| c.is_ascii_digit()))
        .fold(0.0, |m: f64, row| m.max(command_mm(row).abs()));
    assert!((largest - 4.0).abs() < 1e-3, "{largest} mm");
}
