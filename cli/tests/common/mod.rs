//! The binary as people and scripts call it.
#![allow(dead_code, reason = "each file of tests uses a part of it")]

pub mod narrow;

use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command, Output, Stdio};
use std::time::Duration;

/// How long a test waits for an event before it fails: a slow machine may take long.
pub const PATIENCE: Duration = Duration::from_secs(120);

/// Keys in the result of every test: a part of the contract.
pub const KEYS: [&str; 14] = [
    "record",
    "compensation",
    "steps",
    "rate_hz",
    "verdict",
    "trip",
    "eps_max",
    "eps_rms",
    "peak_displacement_m",
    "mean_added_damping_ratio",
    "energy_error_j",
    "energy_error_hsem_j",
    "energy_error_stiffness_j",
    "wall_s",
];

/// Checks that a result matches its schema, and that this key is required; for a list, in its first entry.
#[track_caller]
pub fn is_as_its_schema_says(schema: &str, answer: &Value, without: &str) {
    let schema = json(&["schema", schema]);
    let known = jsonschema::validator_for(&schema).unwrap();
    let wrong: Vec<String> = known
        .iter_errors(answer)
        .map(|e| format!("{}: {e}", e.instance_path()))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let mut other = answer.clone();
    let (first, properties) = match &mut other {
        Value::Array(all) => {
            let name = schema["items"]["$ref"].as_str().unwrap();
            let name = name.strip_prefix("#/$defs/").unwrap();
            (&mut all[0], &schema["$defs"][name]["properties"])
        }
        one => (one, &schema["properties"]),
    };
    // Every key of the result is in the schema.
    for key in first.as_object().unwrap().keys() {
        assert!(properties[key].is_object(), "{key} is in no schema");
    }
    first.as_object_mut().unwrap().remove(without).unwrap();
    assert!(!known.is_valid(&other), "{without} may be left out");
}

/// The folder of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The binary, run in the folder of the workspace.
pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_outerloop"));
    command.args(arguments).current_dir(root());
    command
}

/// Starts it, and reads its standard error up to the line with `word`: gives the process, the rest of standard error,
/// that line.
pub fn started(mut command: Command, word: &str) -> (Child, BufReader<ChildStderr>, String) {
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stderr.take().unwrap());
    let mut line = String::new();
    while !line.contains(word) {
        line.clear();
        assert!(
            said.read_line(&mut line).unwrap() > 0,
            "it never says {word}"
        );
    }
    (child, said, line)
}

/// Sends a signal such as `-TERM` to a process.
#[track_caller]
pub fn send_signal(to: &Child, signal: &str) {
    let kill = Command::new("kill")
        .args([signal, &to.id().to_string()])
        .status();
    assert!(kill.unwrap().success());
}

/// Runs the binary.
pub fn outerloop(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

/// Its output as JSON, with this exit status.
#[track_caller]
pub fn json_with(status: i32, arguments: &[&str]) -> Value {
    let output = outerloop(arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(status), "{said}");
    serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else")
}

/// Its output as JSON, with exit status 0.
#[track_caller]
pub fn json(arguments: &[&str]) -> Value {
    json_with(0, arguments)
}

/// Exit status 2, one sentence on standard error that contains all of `words`, nothing on standard output.
#[track_caller]
pub fn refused(arguments: &[&str], words: &[&str]) {
    let output = outerloop(arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(output.stdout.is_empty());
    assert_eq!(said.trim().lines().count(), 1, "{said}");
    for word in words {
        assert!(said.contains(word), "`{word}` is not in: {said}");
    }
}
