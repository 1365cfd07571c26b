//! `outerloop improve`: what a diagnosis finds makes the next test better, judged by the test's own error.

use crate::common::is_as_its_schema_says;
use serde_json::Value;
use std::path::Path;
use std::process::Command;

fn improve(arguments: &[&str]) -> Vec<Value> {
    let output = Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .arg("improve")
        .args(arguments)
        .arg("--json")
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let answer: Value = serde_json::from_slice(&output.stdout).expect("one JSON object");
    answer["rows"].as_array().unwrap().clone()
}

/// The rig of the examples, with something undeclared.
fn rig(sensors: &str, effect: &str) -> String {
    let example = include_str!("../../../examples/undeclared/friction.toml");
    let (common, _) = example.split_once("[[plant.effects]]").unwrap();
    let common = common.replace("[plant.sensors]", &format!("[plant.sensors]\n{sensors}"));
    format!("{common}\n{effect}")
}

fn effect(name: &str, channel: &str, parameters: &str) -> String {
    let text = format!("[[plant.effects]]\nname = '{name}'\nchannel = '{channel}'\n{parameters}");
    rig("", &text)
}

/// A finding gives one figure, whichever way it reaches the loop: by a model file, by `[declared]`, by `[rig]`. What no loop can
/// take out is said, and changes nothing.
#[test]
fn a_finding_has_one_figure_by_a_model_by_what_is_declared_and_by_the_rig() {
    let folder = tempfile::tempdir().unwrap();
    let run = |test: &str, model: Option<&str>, how: &[&str]| {
        let [at, beside] = ["test.toml", "model.toml"].map(|name| folder.path().join(name));
        std::fs::write(&at, test).unwrap();
        let mut run = Command::new(env!("CARGO_BIN_EXE_outerloop"));
        run.arg("run").arg(&at).args(["--duration", "12"]).args(how);
        if let Some(model) = model {
            std::fs::write(&beside, model).unwrap();
            run.arg("--model").arg(&beside);
        }
        let output = run.output().unwrap();
        [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap())
    };
    let eps_rms = |test: &str, model: Option<&str>| {
        let [answer, said] = run(test, model, &["--json"]);
        let answer: Value = serde_json::from_str(&answer).unwrap_or_else(|e| panic!("{e}: {said}"));
        answer["eps_rms"].as_f64().unwrap()
    };
    let specimen = "stiffness_n_per_mm = { value = 158.0, tolerance = 3.0 }";
    let bearing = "force_n = 300\npresliding_mm = 0.2";
    for (in_rig, table, known, in_loop) in [
        (
            effect("coulomb_friction", "specimen", bearing),
            "specimen",
            format!("{specimen}\n[[specimen.effects]]\nname = 'coulomb_friction'\n{bearing}"),
            "bearing_friction_n = 300\nbearing_presliding_m = 0.2e-3",
        ),
        (
            effect("gain_error", "specimen", "error = 0.05"),
            "specimen",
            format!("{specimen}\n[[specimen.effects]]\nname = 'gain_error'\nerror = 0.05"),
            "force_gain = 1.05",
        ),
        (
            effect("gain_error", "actuator", "error = 0.05"),
            "actuator",
            "gain = { value = 1.05, tolerance = 0.01 }\ndelay_ms = { value = 4.0, tolerance = 0.2 }"
                .into(),
            "command_gain = 1.05",
        ),
    ] {
        let declared = format!("[{table}]\n{known}").replace('[', "[declared.");
        let declared = declared.replace("[declared.[declared.", "[[declared.");
        let without = eps_rms(&in_rig, None);
        let by_model = eps_rms(&in_rig, Some(&format!("[{table}]\n{known}")));
        let by_declared = eps_rms(&format!("{in_rig}\n{declared}"), None);
        let by_rig = eps_rms(&format!("{in_rig}\n[rig]\n{in_loop}"), None);
        assert_eq!(by_model, by_declared, "{in_loop}");
        assert_eq!(by_model, by_rig, "{in_loop}");
        assert!(by_model < 0.5 * without, "{in_loop}: {by_model} of {without}");
    }
    let plain = rig("", "");
    let damping = format!(
        "[specimen]\n{specimen}\n[[specimen.effects]]\nname = 'viscous_damping'\ndamping_n_s_per_mm = 0.5"
    );
    assert_eq!(eps_rms(&plain, Some(&damping)), eps_rms(&plain, None));
    let said = run(&plain, Some(&damping), &[]).concat();
    assert!(
        said.contains("viscous_damping is not taken out: "),
        "{said}"
    );
}

#[test]
fn what_is_taken_out_comes_back_to_the_error_without_it_and_never_gets_worse() {
    // Causes in the true motion, the reading, the force and the timing.
    let taken_out = [
        (
            "motion-offset",
            effect("offset", "actuator", "offset_mm = 2"),
        ),
        (
            "motion-gain",
            effect("gain_error", "actuator", "error = 0.05"),
        ),
        ("reading-offset", rig("displacement_offset_mm = 2", "")),
        ("reading-gain", rig("displacement_gain = 1.05", "")),
        (
            "force-offset",
            effect("offset", "specimen", "offset_n = 300"),
        ),
        (
            "force-gain",
            effect("gain_error", "specimen", "error = 0.05"),
        ),
        ("mass", effect("inertia_force", "specimen", "mass_kg = 60")),
        (
            "bearing",
            effect(
                "coulomb_friction",
                "specimen",
                "force_n = 300\npresliding_mm = 0.2",
            ),
        ),
        (
            "force-late",
            effect("channel_skew", "specimen", "skew_ms = 2"),
        ),
        (
            "reading-late",
            effect("channel_skew", "specimen", "skew_ms = -2"),
        ),
        ("delay", effect("delay_error", "actuator", "delay_ms = 4")),
        ("lag", effect("lag_error", "actuator", "lag_ms = 4")),
        ("second-lag", effect("second_lag", "actuator", "lag_ms = 4")),
        (
            "oil",
            effect(
                "oil_column",
                "actuator",
                "frequency_hz = 20\ndamping_ratio = 0.3",
            ),
        ),
    ];
    // What cannot be removed is reported.
    let stays = [
        ("backlash", effect("backlash", "actuator", "width_mm = 1")),
        (
            "held-back",
            effect(
                "coulomb_friction",
                "actuator",
                "error_mm = 0.5\npresliding_mm = 0.2",
            ),
        ),
        ("drift", effect("drift", "specimen", "rate_n_per_s = 10")),
        (
            "specimen",
            effect("viscous_damping", "specimen", "damping_n_s_per_mm = 0.3"),
        ),
        (
            "stiffening",
            effect("hardening", "specimen", "reference_mm = 100"),
        ),
    ];
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<String> = taken_out
        .iter()
        .chain(&stays)
        .map(|(name, text)| {
            let path = folder.path().join(format!("{name}.toml"));
            std::fs::write(&path, text).unwrap();
            path.display().to_string()
        })
        .collect();
    let rows = improve(&paths.iter().map(String::as_str).collect::<Vec<_>>());
    for row in &rows {
        println!(
            "{} {} -> {}, without {}",
            row["test"], row["eps_rms_before"], row["eps_rms_after"], row["eps_rms_without"]
        );
    }
    let (taken_out, stays) = rows.split_at(taken_out.len());
    for row in taken_out {
        let eps = |key: &str| row[key].as_f64().unwrap();
        assert!(
            eps("eps_rms_after") < 1.1 * eps("eps_rms_without"),
            "{row:#}"
        );
        assert_ne!(row["outcome"], "worse", "{row:#}");
    }
    for row in stays {
        let changes = row["changes"].as_array().unwrap().iter();
        let mut said = changes.filter_map(Value::as_str);
        assert!(said.any(|s| s.contains("is not taken out: ")), "{row:#}");
        assert_eq!(row["outcome"], "same", "{row:#}");
    }
}

#[test]
fn what_a_small_earthquake_cannot_tell_apart_is_settled_by_a_designed_test() {
    // At 2 mm a lag of 4 ms looks like a delay. The rig can move further than the earthquake requires.
    let limits = "[limits]\ndisplacement_m = 0.03\nvelocity_m_per_s = 0.6\nforce_n = 8000\n[[plant.effects]]";
    let text = effect("lag_error", "actuator", "lag_ms = 4")
        .replace("[excitation]", "[excitation]\npeak_response_mm = 2")
        .replace("[[plant.effects]]", limits);
    let folder = tempfile::tempdir().unwrap();
    let (test, out) = (folder.path().join("small.toml"), folder.path().join("out"));
    std::fs::write(&test, text).unwrap();
    let rows = improve(&[
        &test.display().to_string(),
        "--out",
        &out.display().to_string(),
    ]);
    let row = &rows[0];
    let first = row["found_first"].as_str().unwrap();
    assert!(first.ends_with("(or one like it)"), "{row:#}");
    let designed = row["designed"].as_array().unwrap();
    assert_eq!(designed.len(), 1, "{row:#}");
    assert_eq!(designed[0]["limits"]["velocity_from"], "declared");
    assert_eq!(row["found"], "lag_error", "{row:#}");
    assert_eq!(row["outcome"], "better");
    let eps = |key: &str| row[key].as_f64().unwrap();
    assert!(
        eps("eps_rms_after") < 0.3 * eps("eps_rms_before"),
        "{row:#}"
    );
    assert!(out.join("small-next-1.csv").exists() && out.join("small-designed-1.csv").exists());
}

/// A test with converters of 12 bits that are coarse for its peak, in mm.
fn coarse(peak_mm: f64, effect: &str) -> String {
    format!(
        "[structure]
mass_kg = 1000
stiffness_n_per_m = 158e3
damping_ratio = 0.02
[loop]
rate_hz = 2000
[compensation]
window_steps = 10
[excitation]
peak_response_mm = {peak_mm}
duration_s = 8
rest_s = 2
[limits]
displacement_m = 0.045
velocity_m_per_s = 0.6
force_n = 8000
[plant.actuator]
kind = 'delay'
delay_ms = 4
[plant.sensors]
displacement_noise_mm = 0.02
force_noise_n = 5
bits = 12
displacement_range_mm = 50
force_range_n = 10000
[[plant.effects]]
{effect}
"
    )
}

#[test]
fn whatever_the_noise_of_a_small_test_its_lag_is_settled_by_a_designed_one() {
    // The loop's own noise leaves no rest here: a delay and a lag fit equally well.
    let folder = tempfile::tempdir().unwrap();
    let test = folder.path().join("small.toml");
    let text = coarse(2.0, "name = 'lag_error'\nchannel = 'actuator'\nlag_ms = 6");
    std::fs::write(&test, text).unwrap();
    for seed in ["3", "4", "6"] {
        let rows = improve(&[&test.display().to_string(), "--seed", seed]);
        let row = &rows[0];
        let first = row["found_first"].as_str().unwrap();
        assert!(first.ends_with("(or one like it)"), "{seed}: {row:#}");
        assert_eq!(row["found"], "lag_error", "{seed}: {row:#}");
        assert_eq!(row["outcome"], "better", "{seed}: {row:#}");
    }
}

#[test]
fn what_only_the_held_out_part_of_a_test_shows_is_not_called_nothing() {
    // The actuator's largest velocity is reached late: the first part of the record, used for training, leaves only
    // noise.
    let folder = tempfile::tempdir().unwrap();
    let test = folder.path().join("fast.toml");
    let text = coarse(
        5.0,
        "name = 'rate_limit'\nchannel = 'actuator'\nrate_mm_per_s = 40",
    );
    std::fs::write(&test, text).unwrap();
    let rows = improve(&[&test.display().to_string()]);
    let row = &rows[0];
    let actuator = &row["diagnosis"]["channels"][0];
    assert_eq!(actuator["verdict"], "unknown", "{row:#}");
    let notes = actuator["notes"].as_array().unwrap().iter();
    let mut said = notes.filter_map(Value::as_str);
    assert!(
        said.any(|s| s.contains("that the training data do not show")),
        "{row:#}"
    );
}

#[test]
fn the_record_of_a_first_test_of_which_nothing_comes_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let output = Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .args(["improve", "examples/undeclared/inertia.toml"])
        .args(["--duration", "0.2", "--out"])
        .arg(&out)
        .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "{said}");
    assert!(said.contains("samples of test data are too few"), "{said}");
    let kept = std::fs::read_to_string(out.join("inertia-record.csv")).expect("the record");
    assert!(kept.lines().count() > 300, "{said}");
    assert!(!out.join("report.html").exists());
}

#[test]
fn a_worse_second_test_is_called_worse_and_its_model_is_not_handed_on() {
    // The specimen is stiffer than declared. The force channel cannot distinguish this from a load cell that reads too
    // much; the test that follows can.
    let folder = tempfile::tempdir().unwrap();
    let test = folder.path().join("stiffer.toml");
    let text = rig("", "").replace(
        "[plant.sensors]",
        "[plant.specimen]\nstiffness_n_per_m = 168e3\n[plant.sensors]",
    );
    std::fs::write(&test, text).unwrap();
    let out = folder.path().join("out");
    let output = Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .args(["improve", "--json", "--out"])
        .args([&out, &test])
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    is_as_its_schema_says("improve", &answer, "rows");
    let row = &answer["rows"][0];
    assert_eq!(row["outcome"], "worse", "{row:#}");
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("worse than the first"), "{said}");
    assert!(out.join("report.html").exists());
    assert!(!out.join("stiffer-model.toml").exists());
}

#[test]
fn the_next_test_is_nearly_as_good_as_without_the_effect() {
    for (name, effect) in [
        ("inertia", "inertia_force"),
        ("calibration", "gain_error"),
        ("friction", "coulomb_friction"),
        ("lag", "lag_error"),
    ] {
        let rows = improve(&[&format!("examples/undeclared/{name}.toml")]);
        let row = &rows[0];
        let eps = |key: &str| row[key].as_f64().unwrap();
        // Named, or listed as an equal alternative: if no lag is declared, a lag error is also a second lag.
        let channels = row["diagnosis"]["channels"].as_array().unwrap();
        let named = |c: &Value| {
            let alternatives = c["alternatives"].as_array().unwrap();
            c["effects"][0]["name"] == effect || alternatives.contains(&effect.into())
        };
        assert!(channels.iter().any(named), "{name}: {}", row["found"]);
        assert_eq!(row["undeclared"], effect);
        assert!(eps("eps_rms_before") > 0.15, "{name}");
        assert!(eps("eps_rms_after") < 0.3 * eps("eps_rms_before"), "{name}");
        assert!(
            eps("eps_rms_after") < 1.1 * eps("eps_rms_without"),
            "{name}"
        );
    }
}

#[test]
fn a_rig_that_is_as_declared_is_left_alone() {
    let rows = improve(&[
        "examples/undeclared/inertia.toml",
        "--set",
        "plant.effects=[]",
    ]);
    assert_eq!(rows[0]["found"], "nothing");
    assert!(rows[0]["changes"].as_array().unwrap().is_empty());
    assert_eq!(rows[0]["eps_rms_before"], rows[0]["eps_rms_after"]);
}

/// Friction and a late force keep the loop oscillating where it should be at rest: that is no noise. With friction, delay
/// and lag known, 1.25 % can be reached.
#[test]
fn an_error_of_the_method_is_said_to_be_the_methods() {
    let said = |more: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_outerloop"))
            .args([
                "improve",
                "examples/undeclared/inertia.toml",
                "--set",
                "plant.effects=[]",
            ])
            .args(more)
            .current_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(".."))
            .output()
            .unwrap();
        String::from_utf8(output.stdout).unwrap()
    };
    let own = "The error that is left is that of `none`";
    let none = said(&["--set", "compensation.kind='none'", "--duration", "8"]);
    assert!(none.contains(own), "{none}");
    assert!(!said(&[]).contains("The error that is left"));
}

#[test]
fn what_a_hunting_loop_hides_is_found_and_taken_out() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("hunting.toml");
    std::fs::write(
        &file,
        "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
         [loop]\nrate_hz = 2000\n[compensation]\nkind = 'paper'\nwindow_steps = 10\n\
         [excitation]\nduration_s = 30\nrest_s = 2\n\
         [plant.actuator]\nkind = 'lag_delay'\ndelay_ms = 3\nlag_ms = 6\n\
         [plant.sensors]\ndisplacement_noise_mm = 0.01\nforce_noise_n = 15\n\
         [[plant.effects]]\nname = 'stribeck_friction'\nchannel = 'specimen'\nforce_n = 250\nrest_ratio = 1.4\n\
         stribeck_mm_per_s = 10\npresliding_mm = 0.1\n\
         [[plant.effects]]\nname = 'channel_skew'\nskew_ms = 3\n\
         [declared.actuator]\ngain = { value = 1.0, tolerance = 0.005 }\ndelay_ms = { value = 3.0, tolerance = 1.0 }\n\
         lag_ms = { value = 4.0, tolerance = 1.0 }\n\
         [declared.specimen]\nstiffness_n_per_mm = { value = 158, tolerance = 4 }\noffset_n = { value = 0, tolerance = 20 }\n",
    )
    .unwrap();
    let rows = improve(&[file.to_str().unwrap()]);
    let eps = |key: &str| rows[0][key].as_f64().unwrap();
    assert!(eps("eps_rms_before") > 0.09, "{}", eps("eps_rms_before"));
    assert!(
        eps("eps_rms_after") < 1.1 * 0.0125,
        "{}",
        eps("eps_rms_after")
    );
}
