//! The refusal of an unusable command line or file: one sentence each, exit status 2, nothing half written.

use crate::common::{json, outerloop, refused};

const TABLE1: &str = "examples/table1.toml";

#[test]
fn bad_input_gets_one_sentence() {
    refused(
        &["run", "nowhere.toml"],
        &["nowhere.toml", "cannot be read"],
    );
    refused(
        &["run", TABLE1, "--compensation", "magic"],
        &["magic", "eq14", "paper"],
    );
    refused(
        &["run", TABLE1, "--record", "nowhere.csv"],
        &["nowhere.csv"],
    );
    refused(
        &["run", TABLE1, "--set", "plant.actuator.delay_msec=4"],
        &["delay_msec"],
    );
    refused(&["run", TABLE1, "--set", "loop.rate=4"], &["rate"]);
    refused(&["run", TABLE1, "--set", "loop.rate_hz"], &["PATH=VALUE"]);
    refused(&["run", TABLE1, "--set", "loop.rate_hz=fast"], &["fast"]);
    refused(
        &["run", TABLE1, "--set", "loop.rate_hz=-1"],
        &["loop.rate_hz", "-1", "10 to 100000"],
    );
    refused(
        &["run", TABLE1, "--set", "loop.rate_hz=nan"],
        &["loop.rate_hz = NaN"],
    );
    refused(
        &["run", TABLE1, "--set", "structure.mass_kg=nan"],
        &["structure.mass_kg = NaN"],
    );
    // An integration step is set by three keys, and the sentence names them all.
    refused(
        &["run", TABLE1, "--set", "loop.substeps=1000"],
        &[
            "loop.substeps = 1000",
            "loop.rate_hz = 2000",
            "of 500 ms",
            "below 79.6 ms",
        ],
    );
    // What would be ignored: how a file is read where none is, a duration that is swept, a late actuator of the default kind.
    refused(&["run", TABLE1, "--dt", "0.5"], &["--dt", "--record"]);
    let swept = ["--over", "excitation.duration_s=5,10", "--duration", "20"];
    refused(
        &[&["sweep", TABLE1], &swept[..]].concat(),
        &["excitation.duration_s", "--duration", "exclude each other"],
    );
    for delay in ["-1", "2000", "1e9", "inf"] {
        let set = format!("plant.actuator.delay_ms={delay}");
        refused(
            &["run", TABLE1, "--set", &set],
            &["plant.actuator.delay_ms", delay, "0 to 1000 ms"],
        );
    }
    // 4.6 days in the laboratory at 2000 Hz.
    refused(
        &[
            "run",
            TABLE1,
            "--set",
            "loop.time_scale=10000",
            "--duration",
            "3600",
        ],
        &[
            "72000 million control steps",
            "10000 h",
            "GB of memory",
            "loop.time_scale",
        ],
    );
    refused(
        &["run", TABLE1, "--set", "loop.rate_hz=12"],
        &["loop.rate_hz", "natural frequency"],
    );
    refused(
        &["run", TABLE1, "--set", "structure.mass_kg=0"],
        &["structure.mass_kg", "above 0"],
    );
    refused(
        &["run", TABLE1, "--set", "structure.mass_kg=[1,2]"],
        &["as many values as masses"],
    );
    refused(
        &["run", TABLE1, "--set", "compensation.gamma=2"],
        &["compensation.gamma", "2"],
    );
    refused(
        &["run", TABLE1, "--set", "plant.actuator.delay_ms=-3"],
        &["plant.actuator.delay_ms", "-3"],
    );
    refused(
        &["run", TABLE1, "--set", "plant.sensors.bits=99"],
        &["bits", "99"],
    );
    refused(&["run", TABLE1, "--duration", "-1"], &["-1"]);
    refused(&["run", TABLE1, "--duration", "1e9"], &["3600"]);
    refused(&["run", TABLE1, "--duration", "1e-9"], &["floor 1", "0 m"]);
    refused(
        &["run", TABLE1, "--set", "excitation.scale=0"],
        &["excitation.scale", "0"],
    );
    refused(
        &["compare", TABLE1, "--compensations", "paper,magic"],
        &["magic", "eq14"],
    );
    refused(
        &["run", TABLE1, "--out", "/dev/null/x"],
        &["/dev/null/x", "cannot be written"],
    );
}

#[test]
fn a_bad_ground_motion_is_refused_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let uneven = file("a.csv", "time_s,acc_g\n0,0\n0.01,0.1\n0.02,0\n0.05,0\n");
    refused(
        &["run", TABLE1, "--record", &uneven],
        &["a.csv, line 5", "constant interval"],
    );
    let nan = file("b.csv", "# b\ntime_s,acc_g\n0,0\n0.01,nan\n");
    refused(
        &["run", TABLE1, "--record", &nan],
        &["b.csv, line 4", "nan"],
    );
    let unit = file("c.csv", "time_s,acc_ft\n0,0\n0.01,1\n");
    refused(
        &["run", TABLE1, "--record", &unit],
        &["c.csv, line 1", "acc_gal"],
    );
    let head = "PEER\nx\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 5, DT= .01 SEC\n";
    let short = file("d.AT2", &format!("{head}.1 .2 .3\n"));
    refused(
        &["run", TABLE1, "--record", &short],
        &["d.AT2", "NPTS = 5", "3 points"],
    );
    let column = file("e.txt", "0.1\n0.2\n");
    refused(
        &["run", TABLE1, "--record", &column],
        &["e.txt", "--dt", "--unit"],
    );
    let gal = file("f.csv", "time_s,acc_g\n0,0\n0.01,341.7\n");
    refused(
        &["compare", TABLE1, "--record", &gal],
        &["f.csv", "is the unit right?"],
    );
    let rest = file("g.csv", "time_s,acc_g\n0,0\n0.01,0\n");
    refused(
        &["run", TABLE1, "--record", &rest],
        &["g", "every floor moves"],
    );
}

/// A test on a rig costs time and a specimen: what cannot be saved is refused before it.
#[cfg(target_os = "linux")]
#[test]
fn a_place_that_cannot_be_written_is_refused_before_the_test() {
    for (option, place) in [("--out", "/proc/new"), ("--archive", "/proc/new.h5")] {
        // The scope would print its address if the test began.
        let test = ["run", TABLE1, "--scope", "--duration", "2"];
        refused(
            &[&test[..], &[option, place]].concat(),
            &[place, "cannot be written"],
        );
    }
    let served = [
        "serve",
        "examples/opensees.toml",
        "--scope",
        "--out",
        "/proc/new",
    ];
    refused(&served, &["/proc/new", "cannot be written"]);
}

#[test]
fn a_broken_file_leaves_no_folder_behind() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new");
    refused(
        &[
            "run",
            TABLE1,
            "--set",
            "structure.mass_kg=-1",
            "--out",
            out.to_str().unwrap(),
        ],
        &["mass_kg"],
    );
    assert!(!out.exists());
}

#[test]
fn a_misspelled_command_line_gets_one_sentence() {
    refused(
        &["run", TABLE1, "--unit", "furlong"],
        &["--unit", "`furlong`", "g, m/s2, gal"],
    );
    refused(
        &["run", TABLE1, "--recrod", "x"],
        &["`--recrod`", "(`--record`?)", "outerloop run"],
    );
    refused(&["comapre", TABLE1], &["`comapre`", "(`compare`?)"]);
    for (line, meant) in [
        ("board comission", "(`board commission`?)"),
        ("board idnetify", "(`board identify`?)"),
        ("benchmark rth", "(`benchmark rths`?)"),
        ("comission", "(`board commission`?)"),
        ("benchmark rths --records ElCentr", "(`ElCentro`?)"),
        ("keys plant.actuatr", "(`plant.actuator`?)"),
    ] {
        let words: Vec<&str> = line.split(' ').collect();
        refused(&words, &[meant]);
    }
    refused(&["run"], &["<TEST>", "missing"]);
    refused(
        &["run", TABLE1, "--seed", "x"],
        &["--seed", "whole numbers"],
    );
    refused(&["run", TABLE1, "--seed", "-3"], &["--seed", "`-3`"]);
    refused(
        &["benchmark", "rths", "--plants", "-1"],
        &["--plants", "`-1`", "whole numbers"],
    );
    refused(
        &["run", TABLE1, "--duration", "long"],
        &["--duration", "`long`", "numbers"],
    );
    refused(&["run", TABLE1, "--seed"], &["--seed", "no value"]);
    refused(
        &["run", TABLE1, "--seed", "1", "--seed", "2"],
        &["--seed", "twice"],
    );
    refused(
        &["run", TABLE1, "--port", "x", "--emulated"],
        &["--port", "--emulated", "exclude"],
    );
    refused(
        &["benchmark", "rths", "--case", "9"],
        &["--case", "`9`", "1 to 4"],
    );
}

#[test]
fn quiet_prints_what_was_asked_for_and_what_went_wrong() {
    let short = ["run", TABLE1, "--duration", "2", "--quiet"];
    let output = outerloop(&short);
    assert!(output.status.success());
    assert!(output.stdout.is_empty() && output.stderr.is_empty());
    let r = json(&["-q", "run", TABLE1, "--duration", "2", "--json"]);
    assert_eq!(r["verdict"], "completed");
    let tripped = outerloop(&["run", TABLE1, "-q", "--set", "limits.force_n=3000"]);
    assert_eq!(tripped.status.code(), Some(1));
    assert!(tripped.stdout.is_empty());
    let said = String::from_utf8_lossy(&tripped.stderr);
    assert_eq!(said.lines().count(), 1, "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_under_standard_error_is_no_panic() {
    let full = std::fs::File::create("/dev/full").unwrap();
    let status = crate::common::command(&["run", "nowhere.toml"])
        .stderr(full)
        .status()
        .unwrap();
    assert_eq!(status.code(), Some(2));
}
