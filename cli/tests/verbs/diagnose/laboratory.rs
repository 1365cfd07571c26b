//! A rig, its declared model and its records.

use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;
use std::process::{Command, Output};

pub const TEST: &str = r#"
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

pub const MODEL: &str = "
[actuator]
gain = { value = 1, tolerance = 0.01 }
delay_ms = { value = 4, tolerance = 0.5 }
offset_mm = { value = 0, tolerance = 0.05 }
[specimen]
stiffness_n_per_mm = { value = 158, tolerance = 2 }
mass_kg = { value = 0, tolerance = 0.1 }
offset_n = { value = 0, tolerance = 20 }
";

pub const INERTIA: &str = "[[plant.effects]]\nname = \"inertia_force\"\nmass_kg = 60\n";

pub fn outerloop(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .args(arguments)
        .output()
        .unwrap()
}

/// A folder with a model, and the record of a test on a rig with `effect`.
pub struct Laboratory {
    folder: tempfile::TempDir,
}

impl Laboratory {
    pub fn with(effect: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let here = Self { folder };
        here.write("test.toml", &format!("{TEST}{effect}"));
        here.write("model.toml", MODEL);
        let (test, out) = (here.path("test.toml"), here.path("out"));
        let run = outerloop(&["run", &test, "--out", &out]);
        // Status 1: the undeclared effect makes the test wrong, which is the purpose of its record.
        let code = run.status.code();
        assert!(
            matches!(code, Some(0 | 1)),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        here
    }

    pub fn path(&self, name: &str) -> String {
        self.folder.path().join(name).display().to_string()
    }

    pub fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.path().join(name), text).unwrap();
    }

    pub fn record(&self) -> String {
        self.path("out/record.csv")
    }

    /// Diagnoses `model` with the first part of `record` for training and the last for judging.
    pub fn halves(&self, model: &str, record: &str, more: &[&str]) -> Output {
        let (train, test) = (format!("{record}@0..11"), format!("{record}@11.001..21.4"));
        let mut arguments = vec![
            "diagnose", "--model", model, "--train", &train, "--test", &test,
        ];
        arguments.extend(more);
        outerloop(&arguments)
    }

    pub fn diagnose(&self, model: &str, record: &str) -> Value {
        let output = self.halves(model, record, &["--json"]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{said}");
        serde_json::from_slice(&output.stdout).expect("one JSON object and nothing else")
    }

    /// Refused with exit status 2 and one sentence that contains all of `words`.
    #[track_caller]
    pub fn refused(&self, model: &str, train: &str, test: &str, more: &[&str], words: &[&str]) {
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

    /// Time, command, displacement and force of the record, changed row by row, in a new file.
    pub fn changed(&self, name: &str, change: impl Fn(usize, &mut [String; 4])) -> String {
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

pub fn channel<'a>(d: &'a Value, name: &str) -> &'a Value {
    let channels = d["channels"].as_array().unwrap();
    channels.iter().find(|c| c["channel"] == name).unwrap()
}
