//! Exit statuses, a standard output that fails, and the places where results are written.

use crate::common::{command, json, json_with, outerloop};
use std::fs;

const TABLE1: &str = "examples/table1.toml";
const THREE: &str = "examples/three-storey.toml";

#[test]
fn a_script_can_tell_a_good_test_from_a_bad_one() {
    let short = ["--json", "--duration", "8"];
    let run = [&["run", TABLE1][..], &short].concat();
    assert_eq!(json(&run)["verdict"], "completed");
    let away = json_with(1, &["run", TABLE1, "--json", "--compensation", "none"]);
    assert_eq!(away["verdict"], "diverged");
    // A delay large enough for a wrong result, but not for running away.
    let wrong = json_with(
        1,
        &[&run[..], &["--set", "plant.actuator.delay_ms=20"]].concat(),
    );
    assert_eq!(wrong["verdict"], "completed");
    let all = json(&["compare", TABLE1, "--compensations", "none,paper", "--json"]);
    assert_eq!(all["rows"][0]["verdict"], "diverged");
    json_with(1, &["compare", TABLE1, "--compensations", "none", "--json"]);
    let help = String::from_utf8(outerloop(&["run", "--help"]).stdout).unwrap();
    assert!(
        help.contains("Exit status:") && help.contains("ran away"),
        "{help}"
    );
    let below = outerloop(&["monte-carlo", TABLE1, "--tests", "-1"]);
    let said = String::from_utf8(below.stderr).unwrap();
    assert!(
        below.status.code() == Some(2) && said.contains("--tests <TESTS>: `-1` is refused"),
        "{said}"
    );
}

#[test]
fn a_simulated_runaway_is_stopped_before_its_numbers_mean_nothing() {
    let r = json_with(1, &["run", THREE, "--json", "--compensation", "none"]);
    assert_eq!(r["verdict"], "diverged");
    assert!(r["stopped_s"].as_f64().unwrap() < 12.0, "{r}");
    let peak = r["peak_displacement_m"].as_f64().unwrap();
    assert!(peak.is_finite() && peak < 100.0, "{peak}");
    let output = outerloop(&["run", THREE, "--compensation", "none"]);
    let said = [output.stdout, output.stderr].concat();
    let said = String::from_utf8(said).unwrap();
    let digits = |word: &str| word.chars().filter(char::is_ascii_digit).count();
    let longest = said.split(|c: char| !c.is_ascii_digit() && c != '.');
    assert!(longest.map(digits).max() <= Some(6), "{said}");
    assert!(said.contains("The simulation was stopped there"), "{said}");
}

#[cfg(unix)]
#[test]
fn a_signal_before_a_board_is_armed_says_that_nothing_has_moved() {
    use std::io::Read as _;
    use std::os::unix::fs::PermissionsExt as _;
    let home = tempfile::tempdir().unwrap();
    // An emulator that never replies.
    let silent = home.path().join("emu");
    fs::write(&silent, "#!/bin/sh\necho started >&2\ncat >/dev/null\n").unwrap();
    fs::set_permissions(&silent, fs::Permissions::from_mode(0o755)).unwrap();
    for signal in ["-INT", "-TERM", "-HUP"] {
        let out = home.path().join("out");
        let mut run = command(&["run", TABLE1, "--emulated", "--out", out.to_str().unwrap()]);
        run.env("OUTERLOOP_EMULATOR", &silent)
            .env("OUTERLOOP_IMAGE", &silent);
        let (mut running, mut rest, _) = crate::common::started(run, "started");
        crate::common::send_signal(&running, signal);
        assert_eq!(running.wait().unwrap().code(), Some(1), "{signal}");
        let mut said = String::new();
        rest.read_to_string(&mut said).unwrap();
        assert!(said.contains("before the board was armed"), "{said}");
        assert!(!out.exists());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_under_standard_output_is_one_sentence() {
    for verb in [
        &["run", TABLE1, "--duration", "3"][..],
        &["run", TABLE1, "--duration", "3", "--json"],
        &["effects"],
        &["effects", "--json"],
        &["--help"],
    ] {
        let full = fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap();
        let output = command(verb).stdout(full).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{verb:?}: {said}");
        assert!(said.contains("standard output cannot be written"), "{said}");
        assert_eq!(said.trim().lines().count(), 1, "{said}");
    }
}

#[test]
fn a_slip_of_the_pen_is_remarked() {
    let output = outerloop(&[
        "run",
        TABLE1,
        "--duration",
        "5",
        "--set",
        "structure.stiffness_n_per_m=158",
    ]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("15.8 s") && said.contains("N/m"), "{said}");

    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("short.csv");
    fs::write(&record, "time_s,acc_g\n0,0\n0.01,0.1\n0.02,0\n0.03,0.1\n").unwrap();
    let record = record.to_str().unwrap();
    let output = outerloop(&["run", TABLE1, "--record", record]);
    let said = String::from_utf8(output.stdout).unwrap();
    assert!(said.contains("30.0 ms long"), "{said}");
}
