//! `outerloop identify` on a real actuator's record, and what it writes into a test file.

use serde_json::Value;
use std::process::{Command, Output};

fn outerloop(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_outerloop"))
        .args(arguments)
        .output()
        .unwrap()
}

/// The measured data, if they are on this machine.
fn measured(name: &str) -> Option<String> {
    Some(
        test_data::file(&format!("measured/{name}"))?
            .display()
            .to_string(),
    )
}

fn identified(file: &str) -> Value {
    let out = outerloop(&["identify", file, "--json"]);
    let said = String::from_utf8_lossy(&out.stderr);
    assert!(out.status.success(), "{said}");
    serde_json::from_slice(&out.stdout).unwrap()
}

#[test]
fn the_measured_chirp_gives_the_published_lag_and_delay() {
    let Some(file) = measured("utfsm_chirp_0A.csv") else {
        return;
    };
    let found = identified(&file);
    let number = |key: &str| found[key].as_f64().unwrap();
    println!("{found}");
    assert!((number("lag_ms") - 22.2).abs() < 1.0, "{found}");
    assert!((number("delay_ms") - 4.6).abs() < 0.7, "{found}");
    for key in ["gain", "delay_ms", "lag_ms", "offset_mm"] {
        let interval = &found[format!("{key}_ci90")];
        let [low, high] = [0, 1].map(|i| interval[i].as_f64().unwrap());
        assert!(low < number(key) && number(key) < high, "{key}: {found}");
    }
    assert!(number("nrmse") < 0.2, "{found}");
}

#[test]
fn a_rig_is_found_again_and_written_into_its_test_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let test = path("test.toml");
    let text = "# what is tested\n[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
                [excitation]\nduration_s = 15\n[plant.actuator] # the rig\nkind = \"lag_delay\"\ndelay_ms = 3 # late\n\
                lag_ms = 5\ngain = 0.98\n[plant.specimen]\nkind = \"linear\"\n";
    std::fs::write(&test, text).unwrap();
    let run = outerloop(&["run", &test, "--out", &path("out")]);
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );

    std::fs::write(
        &test,
        text.replace("lag_delay", "servo_hydraulic")
            .replace("lag_ms = 5\n", "")
            + "[declared.actuator]\ndelay_ms = { value = 4.0, tolerance = \"0.6 ms\" } # believed\n\
               lag_ms = { value = 0.0, tolerance = 0.0 }\n",
    )
    .unwrap();
    let out = outerloop(&["identify", &path("out/record.csv"), "--write", &test]);
    assert!(
        out.status.success(),
        "{}",
        String::from_utf8_lossy(&out.stderr)
    );
    let written = std::fs::read_to_string(&test).unwrap();
    assert!(written.starts_with("# what is tested\n"), "{written}");
    assert!(written.contains("# late"), "{written}");
    assert!(written.contains("# believed"), "{written}");
    let table: toml::Table = written.parse().unwrap();
    let number = |path: [&str; 3]| table[path[0]][path[1]][path[2]].as_float().unwrap();
    assert_eq!(
        table["plant"]["actuator"]["kind"].as_str(),
        Some("lag_delay")
    );
    // The converter holds each command for a step of half a millisecond, which also acts as a delay.
    let delay = number(["plant", "actuator", "delay_ms"]);
    let lag = number(["plant", "actuator", "lag_ms"]);
    assert!(
        (delay - 3.0).abs() < 0.6 && (lag - 5.0).abs() < 0.3,
        "{written}"
    );
    assert!(
        (number(["plant", "actuator", "gain"]) - 0.98).abs() < 0.002,
        "{written}"
    );
    let declared =
        |key: &str, part: &str| table["declared"]["actuator"][key][part].as_float().unwrap();
    assert_eq!(declared("delay_ms", "value"), delay, "{written}");
    assert_eq!(declared("delay_ms", "tolerance"), 0.6, "{written}");
    assert_eq!(declared("lag_ms", "value"), lag, "{written}");
    assert_eq!(declared("lag_ms", "tolerance"), 0.5, "{written}");
    let both = table["compensation"]["delay_ms"].as_float().unwrap();
    assert!((both - delay - lag).abs() < 2e-3, "{written}");
    assert!(outerloop(&["check", &test]).status.code() != Some(2));
}

/// A smooth motion of several frequencies, mm.
fn motion(t: f64) -> f64 {
    10.0 * (1.7 * t).sin() + 4.0 * (7.3 * t).sin() + (23.0 * t).sin()
}

#[test]
fn a_reversed_or_early_displacement_is_named_and_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let test = path("test.toml");
    let text = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n";
    std::fs::write(&test, text).unwrap();
    for (moved, said) in [
        (
            &(|t: f64| -motion(t - 0.01)) as &dyn Fn(f64) -> f64,
            "polarity is reversed",
        ),
        (&|t: f64| motion(t + 0.08), "80.0 ms before its command"),
        (&|t: f64| 1000.0 * motion(t - 0.01), "is the unit"),
    ] {
        let rows: String = (0..8000)
            .map(|i| f64::from(i) * 1e-3)
            .map(|t| format!("{t},{},{}\n", motion(t), moved(t)))
            .collect();
        let file = path("r.csv");
        std::fs::write(&file, format!("time_s,command_mm,displacement_mm\n{rows}")).unwrap();
        for (more, status) in [(&[][..], 1), (&["--write", &test], 2)] {
            let out = outerloop(&[&["identify", &file][..], more].concat());
            let error = String::from_utf8_lossy(&out.stderr).into_owned();
            assert_eq!(out.status.code(), Some(status), "{error}");
            assert!(error.contains(said), "{error}");
        }
        assert_eq!(std::fs::read_to_string(&test).unwrap(), text);
    }
}

#[test]
fn a_time_of_another_unit_is_asked_about_once() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("r.csv");
    for (factor, unit) in [
        (1e3, "milliseconds"),
        (1e6, "microseconds"),
        (1e-3, "minutes"),
    ] {
        let rows: String = (0..8000)
            .map(|i| f64::from(i) * 1e-3)
            .map(|t| format!("{},{},{}\n", factor * t, motion(t), motion(t - 0.01)))
            .collect();
        std::fs::write(&file, format!("time_s,command_mm,displacement_mm\n{rows}")).unwrap();
        let out = outerloop(&["identify", &file.display().to_string()]);
        let said = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(1), "{said}");
        assert_eq!(said.matches("Is the time in").count(), 1, "{said}");
        assert!(said.contains(unit), "{said}");
    }
}

#[test]
fn mistakes_are_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("r.csv");
    let rows: String = (0..300)
        .map(|i| format!("{},{}\n", f64::from(i) * 1e-3, i % 7))
        .collect();
    for (text, said) in [
        (format!("time_s,displacement_mm\n{rows}"), "has no command"),
        (format!("time_s,command_mm\n{rows}"), "has no displacement"),
    ] {
        std::fs::write(&file, text).unwrap();
        let out = outerloop(&["identify", &file.display().to_string()]);
        let error = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(2), "{error}");
        assert!(
            error.contains(said) && error.trim_end().lines().count() == 1,
            "{error}"
        );
    }
}
