//! `outerloop board commission --emulated` on the image for three actuators: each in its turn, and what is found of it.
#![allow(missing_docs)]

mod common;

use common::{command, root};

/// What the simulated actuators are, ms.
const LATE_MS: [f64; 3] = [4.0, 6.0, 9.0];

#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn three_actuators_of_the_emulated_board_are_each_found() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let example = std::fs::read_to_string(root().join("examples/three-storey.toml")).unwrap();
    let each = format!("\ndelay_ms = {LATE_MS:?}");
    let test = example.replace("\ndelay_ms = 4", &each);
    assert!(test.contains(&each));
    std::fs::write(at("three.toml"), test).unwrap();
    let [three, chirp] = ["three.toml", "chirp.csv"].map(|name| at(name).display().to_string());
    let signal = ["--amplitude-mm", "2", "--seconds", "4", "--to-hz", "10"];
    let output = command(&["board", "commission", &three, "--emulated", "--out", &chirp])
        .args(signal)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.success(),
        "{said}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    println!("{said}");

    // What is to be written into the test file.
    let line = said
        .lines()
        .find_map(|l| l.strip_prefix("compensation.delay_ms = "));
    let told: Vec<f64> = serde_json::from_str(line.unwrap()).unwrap();
    assert_eq!(told.len(), LATE_MS.len());
    for (found, truth) in told.iter().zip(LATE_MS) {
        assert!((found - truth).abs() < 0.1, "{found} of {truth} ms");
    }
    // Each recording, and each column of the stiffness of the frame, of 797.3 kN/m a storey.
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
