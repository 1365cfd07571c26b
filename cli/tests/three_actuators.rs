//! The image for three actuators with different delays, as a person uses it: commissioning, and a test with a predictor.
#![allow(missing_docs)]

mod common;

use common::{command, narrow, root};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Delays of the simulated actuators, ms.
const LATE_MS: [f64; 3] = [4.0, 6.0, 9.0];

/// The example with three actuators that differ.
fn test_file(folder: &Path) -> PathBuf {
    let example = std::fs::read_to_string(root().join("examples/three-storey.toml")).unwrap();
    let each = format!("\ndelay_ms = {LATE_MS:?}");
    let test = example.replace("\ndelay_ms = 4", &each);
    assert!(test.contains(&each));
    let file = folder.join("three.toml");
    std::fs::write(&file, test).unwrap();
    file
}

/// The board's output is the predictor's command, each actuator with its own delay, and not the target.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn what_is_sent_ahead_of_a_target_is_no_dead_output() {
    let folder = tempfile::tempdir().unwrap();
    let test = test_file(folder.path()).display().to_string();
    let output = command(&["run", &test, "--emulated", "--json", "--duration", "4"])
        .args(["--compensation", "afp"])
        .output()
        .unwrap();
    let said: Value = serde_json::from_slice(&output.stdout).unwrap();
    let (eps_rms, board) = (said["eps_rms"].as_f64().unwrap(), &said["board"]);
    println!("eps_rms {eps_rms}, {board}");
    assert!(eps_rms < 0.005, "{eps_rms}");
    assert_eq!(
        (&board["steps_lost"], &board["steps_different"]),
        (&0.into(), &0.into())
    );
    let off_m = board["further"]["command_off_m"].as_f64().unwrap();
    assert!(off_m < 1e-4, "{off_m}");
}

/// The board's time is its own: the archive has everything needed to repeat it.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn an_archived_test_on_an_emulated_board_is_replayed_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let test = test_file(folder.path()).display().to_string();
    let file = folder.path().join("test.h5").display().to_string();
    let run = ["run", &test, "--emulated", "--duration", "1"];
    let archived = ["--compensation", "afp", "--archive", &file];
    assert!(command(&run).args(archived).status().unwrap().success());
    let output = command(&["replay", &file, "--json"]).output().unwrap();
    let found: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(found["values_different"], 0, "{found}");
    assert!(found["steps"].as_u64().unwrap() >= 1000, "{found}");
}

#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn three_actuators_of_the_emulated_board_are_each_found() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    test_file(folder.path());
    let [three, chirp] = ["three.toml", "chirp.csv"].map(|name| at(name).display().to_string());
    let signal = ["--amplitude-mm", "2", "--seconds", "4", "--to-hz", "10"];
    let mut commission = command(&["board", "commission", &three, "--emulated", "--out", &chirp]);
    commission.args(signal);
    let (status, text) = narrow::told(commission);
    println!("{text}");
    assert_eq!(status, Some(0));
    narrow::check("board commission", &text);
    assert!(!text.contains("are replaced"), "it is its own file");
    let said = narrow::seen(&text);

    // The lines for the test file.
    let line = said
        .iter()
        .find_map(|l| l.strip_prefix("compensation.delay_ms = "));
    let told: Vec<f64> = serde_json::from_str(line.unwrap()).unwrap();
    assert_eq!(told.len(), LATE_MS.len());
    for (found, truth) in told.iter().zip(LATE_MS) {
        assert!((found - truth).abs() < 0.1, "{found} of {truth} ms");
    }
    // Each recording, and each column of the frame's stiffness, 797.3 kN/m per storey.
    let kept: toml::Table = std::fs::read_to_string(at("chirp-actuators.toml"))
        .unwrap()
        .parse()
        .unwrap();
    let storey = 797.3e3;
    let frame = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]];
    for (j, actuator) in kept["actuator"].as_array().unwrap().iter().enumerate() {
        let record = std::fs::read_to_string(at(&format!("chirp-{}.csv", j + 1))).unwrap();
        assert!(record.lines().count() > 8000, "4 s at 2000 Hz");
        let column = actuator["stiffness_n_per_m"].as_array().unwrap();
        for (found, truth) in column.iter().zip(frame[j]) {
            let found = found.as_float().unwrap();
            assert!((found - truth * storey).abs() < 0.01 * storey, "{found}");
        }
    }
}
