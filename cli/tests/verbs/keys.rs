//! `outerloop keys` and `new`: the page matches the code, and what they write is accepted.

use crate::common::{command, is_as_its_schema_says, json, outerloop, refused, root};
use serde_json::{Value, json};
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
        ("plant.sensors.bits", "bit", "null", "2 to 32"),
        (
            "plant.specimen.yield_mm",
            "mm",
            "null",
            "0.000001 to 1000000 mm",
        ),
        ("plant.specimen.hardening_ratio", "1", "null", "0 to 1"),
        ("plant.specimen.sharpness", "1", "null", "0.5 to 50"),
        ("plant.specimen.loop_shape", "1", "null", "0.5 to 1"),
        ("compensation.hydraulic.b1", "rad/s", "null", "above 0"),
        ("compensation.inverse", "s, s², s³", "null", "-10 to 10"),
        ("excitation.rest_s", "s", "0.0", "0 to 60 s"),
        (
            "declared.coupled.mass",
            "varies",
            "null",
            "rows of { value = , tolerance = }",
        ),
    ] {
        let k = key(path);
        assert_eq!(k["unit"], unit, "{k}");
        assert_eq!(k["default"].as_str().unwrap_or("null"), default, "{k}");
        assert!(k["accepted"].as_str().unwrap().contains(accepted), "{k}");
    }
    let remainder = |name: &str| key(&format!("declared.specimen.remainder.{name}"));
    for (name, unit, accepted) in [
        ("strengths", "varies", "finite numbers"),
        ("range.other", "mm", "finite numbers"),
        ("range.seconds", "s", "numbers above 0"),
        (
            "range.x_mm",
            "mm",
            "two finite numbers, the first the smaller",
        ),
    ] {
        let k = remainder(name);
        assert_eq!([&k["unit"], &k["accepted"]], [unit, accepted], "{k}");
    }
    refused(&["keys", "no such thing"], &["no such thing"]);
}

/// The unit at the end of a key's name, worked out from its parts: `damping_n_s_per_mm` gives `N s/mm`.
fn unit_in(name: &str) -> Option<String> {
    let symbol = |part: &str| match part {
        "n" => Some("N"),
        "kn" => Some("kN"),
        "j" => Some("J"),
        "hz" => Some("Hz"),
        "s2" => Some("s²"),
        "seconds" => Some("s"),
        "bits" => Some("bit"),
        "steps" | "substeps" => Some("steps"),
        "per" => Some("/"),
        other => ["m", "mm", "s", "ms", "kg", "rad"]
            .into_iter()
            .find(|own| *own == other),
    };
    let mut parts: Vec<&str> = name.rsplit('_').map_while(symbol).collect();
    parts.reverse();
    let unit = parts.join(" ").replace(" / ", "/").replace("/ ", "1/");
    (!unit.is_empty()).then_some(unit)
}

#[test]
fn a_unit_agrees_with_the_name_of_its_key_and_with_its_meaning() {
    let words = [
        "s", "ms", "mm", "m", "N", "kN", "J", "Hz", "rad", "kg", "metre", "metres", "seconds",
        "newton", "newtons", "units",
    ];
    let mut wrong = Vec::new();
    for key in json(&["keys", "--json"])
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|group| group["keys"].as_array().unwrap())
    {
        let [path, unit, meaning] = ["path", "unit", "meaning"].map(|k| key[k].as_str().unwrap());
        let name = path.rsplit('.').next().unwrap();
        if unit_in(name).is_some_and(|own| own != unit) {
            wrong.push(format!("{path}: {unit}"));
        }
        let said = meaning
            .split(|c: char| !(c.is_alphanumeric() || c == '\'' || c == '_'))
            .find(|word| words.contains(word));
        if let ("1", Some(said)) = (unit, said) {
            wrong.push(format!("{path}: 1, but its meaning says `{said}`"));
        }
        if unit.is_empty() && key["accepted"].as_str().unwrap().contains("rows of") {
            wrong.push(format!("{path}: rows of numbers without a unit"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn what_is_accepted_is_a_range_and_no_refusal() {
    let printed = [
        json(&["keys", "--json"]),
        json(&["schema", "test"]),
        json(&["schema", "model"]),
    ];
    // Of a key, and of a schema's description.
    let accepted = |text: &str| {
        let (_, after) = text.split_once("Accepted: ")?;
        Some(after.to_owned())
    };
    let mut open: Vec<&Value> = printed.iter().collect();
    let (mut said, mut count) = (Vec::new(), 0);
    while let Some(value) = open.pop() {
        match value {
            Value::Object(map) => {
                said.extend(
                    map.get("accepted")
                        .and_then(Value::as_str)
                        .map(str::to_owned),
                );
                said.extend(
                    map.get("description")
                        .and_then(Value::as_str)
                        .and_then(accepted),
                );
                open.extend(map.values());
            }
            Value::Array(list) => open.extend(list),
            _ => {}
        }
    }
    for text in &said {
        count += 1;
        for of_a_refusal in [
            "beside",
            "sequence",
            "parameter",
            "only",
            "refused",
            "invalid",
        ] {
            assert!(!text.contains(of_a_refusal), "{text}");
        }
    }
    assert!(count > 300, "{count} texts");
}

#[test]
fn a_schema_accepts_units_where_a_file_does() {
    let test = json(&["schema", "test"]);
    let known = jsonschema::validator_for(&test).unwrap();
    let structure = json!({
        "mass_kg": ["1 t", 900], "stiffness_n_per_m": "158 kN/m", "damping_ratio": "2 %",
    });
    for (table, keys, accepted) in [
        (
            "plant",
            r#"{"coupled": {"actuators": {"lead_ms": [["1 s", 0], [0, 0]]}}}"#,
            true,
        ),
        (
            "plant",
            r#"{"coupled": {"actuators": {"lead_ms": "1 s"}}}"#,
            false,
        ),
        ("serve", r#"{"settle_ms": "1 s"}"#, true),
        ("serve", r#"{"carry_force": "5 m"}"#, false),
        ("compensation", r#"{"inverse": [0.01, 0, 0]}"#, true),
        ("compensation", r#"{"inverse": ["5 s", 0, 0]}"#, false),
    ] {
        let mut file = json!({ "structure": structure });
        file[table] = serde_json::from_str(keys).unwrap();
        assert_eq!(known.is_valid(&file), accepted, "[{table}] {keys}");
    }
    let model = json(&["schema", "model"]);
    let known = jsonschema::validator_for(&model).unwrap();
    let stiffness = json!({ "value": "158 kN/m", "tolerance": 2 });
    assert!(known.is_valid(&json!({ "specimen": { "stiffness_n_per_mm": stiffness } })));
    assert!(!known.is_valid(&json!({ "specimen": { "stiffness_n_per_mm": "158 kN/m" } })));
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
