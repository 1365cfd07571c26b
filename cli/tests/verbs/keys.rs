//! `outerloop keys` and `new`: the page is what the code says, and what they write is accepted.

use crate::common::{command, json, outerloop, refused, root};
use std::io::Write;
use std::process::Stdio;

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
    let schema = json(&["keys", "--schema"]);
    for example in [
        "table1",
        "steel-frame",
        "three-storey",
        "hybrid",
        "coupled-frame",
        "hydraulic-ram",
    ] {
        let text =
            std::fs::read_to_string(root().join(format!("examples/{example}.toml"))).unwrap();
        let table: toml::Table = text.parse().unwrap();
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
        .write_all(b"1\n2000\n300\n3\n6\n\n50\n10\n\n")
        .unwrap();
    let output = asks.wait_with_output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(
        output.status.success() && said.contains("Mass of a floor"),
        "{said}"
    );
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
