//! `outerloop serve` with OpenSees itself: OpenSeesPy from PyPI, which `scripts/setup` installs under `target`.
#![allow(missing_docs)]

mod common;

use common::{command, root, started};
use serde_json::Value;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};

/// The Python that has OpenSees; `None` and a message if it is missing.
fn python() -> Option<PathBuf> {
    let target = std::env::var_os("CARGO_TARGET_DIR").unwrap_or_else(|| "target".into());
    let python = root().join(target).join("opensees/bin/python");
    if !python.is_file() {
        test_data::not_run("OpenSeesPy is not installed (scripts/opensees-venv)");
        return None;
    }
    Some(python)
}

struct Server(Child, String);

impl Server {
    fn start(test: &str, arguments: &[&str]) -> Self {
        // A board that is built first prints other lines before.
        let mut serve = command(&["serve", test, "--once", "--json"]);
        serve.args(["--listen", "127.0.0.1:0"]).args(arguments);
        let (child, mut said, line) = started(serve, "outerloop: serves");
        let port = line
            .rsplit_once(';')
            .expect(&line)
            .0
            .rsplit_once(':')
            .unwrap();
        let port = port.1.to_owned();
        std::thread::spawn(move || std::io::copy(&mut said, &mut std::io::sink()));
        Self(child, port)
    }

    fn account(mut self) -> Value {
        let mut out = String::new();
        let pipe = self.0.stdout.as_mut().unwrap();
        pipe.read_to_string(&mut out).unwrap();
        let _ = self.0.wait();
        serde_json::from_str(&out).expect("one JSON object")
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// The output of a model, and the rig's account of it.
fn both(python: &Path, model: &str, words: &[&str], server: Server) -> (Value, Value) {
    let out = Command::new(python)
        .arg(model)
        .args(["--port", &server.1])
        .args(words)
        .current_dir(root())
        .output()
        .unwrap();
    let (said, printed) = (
        String::from_utf8_lossy(&out.stderr),
        String::from_utf8_lossy(&out.stdout),
    );
    let line = printed.lines().find(|line| line.starts_with('{'));
    let line = line.unwrap_or_else(|| panic!("{printed}{said}"));
    (serde_json::from_str(line).unwrap(), server.account())
}

const MODEL: &str = "examples/opensees/one_storey.py";
const RIG: &str = "examples/opensees.toml";

#[test]
fn the_served_specimen_is_the_own_element_of_opensees_to_a_billionth_at_a_thousand_steps_a_second()
{
    let Some(python) = python() else { return };
    let (model, rig) = both(&python, MODEL, &[], Server::start(RIG, &[]));
    let number = |key: &str| model[key].as_f64().unwrap();
    assert!(number("peak_m") > 0.05 && number("apart") < 1e-9, "{model}");
    assert!(number("steps_per_s") > 1000.0, "{model}");
    assert_eq!(rig["verdict"], "completed", "{rig}");
    assert_eq!(rig["targets"], 3000);
    for integrator in [["AlphaOS", "0.9"], ["AlphaOSGeneralized", "0.9"]] {
        let words = [
            "--steps",
            "300",
            "--integrator",
            integrator[0],
            integrator[1],
        ];
        let (model, rig) = both(&python, MODEL, &words, Server::start(RIG, &[]));
        assert!(
            model["apart"].as_f64().unwrap() < 1e-9,
            "{integrator:?} {model}"
        );
        assert_eq!(rig["verdict"], "completed", "{rig}");
    }
}

#[test]
fn a_corner_half_of_which_two_coupled_actuators_hold_moves_as_in_opensees_alone() {
    let Some(python) = python() else { return };
    let rig = [
        "--set",
        "plant.coupled.specimen.springs=[]",
        "--set",
        "serve.settle_ms=100",
        "--set",
        "serve.average_ms=50",
    ];
    let server = Server::start("examples/coupled-frame.toml", &rig);
    let (model, rig) = both(&python, "examples/opensees/corner.py", &[], server);
    println!("{model}");
    let number = |key: &str| model[key].as_f64().unwrap();
    assert!(
        number("peak_m") > 0.02 && number("peak_rad") > 0.005,
        "{model}"
    );
    // The noise of the readings, which a model in closed loop accumulates.
    assert!(
        number("apart_x") < 2e-3 && number("apart_rotation") < 2e-2,
        "{model}"
    );
    assert_eq!(rig["verdict"], "completed", "{rig}");
    assert_eq!(rig["targets"], 300);
}

#[test]
fn an_integrator_that_iterates_is_refused() {
    let Some(python) = python() else { return };
    let server = Server::start(RIG, &[]);
    let out = Command::new(python)
        .args([
            MODEL,
            "--port",
            &server.1,
            "--algorithm",
            "Newton",
            "--integrator",
            "Newmark",
            "0.5",
            "0.25",
        ])
        .current_dir(root())
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&out.stdout);
    assert!(
        !printed.contains("peak_m") || printed.contains("NaN"),
        "{printed}"
    );
    let rig = server.account();
    assert_eq!(
        (&rig["verdict"], &rig["permit"]),
        (&"refused".into(), &false.into())
    );
    assert!(rig["reason"].to_string().contains("iterates"), "{rig}");
}

#[test]
fn a_model_in_opensees_that_is_sometimes_late_is_waited_for() {
    let Some(python) = python() else { return };
    let server = Server::start(
        RIG,
        &[
            "--set",
            "serve.pace=continuous",
            "--set",
            "loop.substeps=20",
            "--set",
            "loop.solve_substeps=14",
        ],
    );
    let words = ["--steps", "300", "--late-every", "50", "--late-ms", "60"];
    let (model, rig) = both(&python, MODEL, &words, server);
    assert_eq!(rig["verdict"], "completed", "{rig}");
    assert!(rig["late_targets"].as_u64().unwrap() >= 5, "{rig}");
    let longest = rig["longest_late_ms"].as_f64().unwrap();
    assert!((30.0..120.0).contains(&longest), "{rig}");
    // An ideal actuator passes exactly through each target: a late model costs time, not accuracy.
    assert!(model["apart"].as_f64().unwrap() < 1e-5, "{model}");
}

#[test]
fn a_steel_frame_with_its_brace_in_the_laboratory_is_the_frame_with_its_own_brace() {
    let Some(python) = python() else { return };
    let server = Server::start(
        "examples/opensees/frame.toml",
        &[
            "--set",
            "serve.pace=stop_and_go",
            "--set",
            "loop.approach_m_per_s=0.2",
            "--set",
            "plant.actuator.kind=ideal",
        ],
    );
    let words = ["--seconds", "10"];
    let (model, rig) = both(&python, "examples/opensees/frame.py", &words, server);
    assert_eq!(rig["verdict"], "completed", "{rig}");
    // The brace yields, so the bilinear hysteresis here and Steel01 there are also compared.
    assert!(model["peak_m"].as_f64().unwrap() > 0.009, "{model}");
    assert!(model["eps_max"].as_f64().unwrap() < 1e-6, "{model}");
}

/// A frame whose brace is behind the emulated board: the flashed image, its converters, a yielding specimen on an
/// actuator with a delay of 12 ms.
#[test]
#[ignore = "needs the image and the emulator: scripts/emu-test runs it"]
fn a_steel_frame_with_its_brace_behind_the_emulated_board_completes_and_every_step_is_proven() {
    let Some(python) = python() else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let server = Server::start(
        "examples/opensees/frame.toml",
        &["--emulated", "--out", out],
    );
    let words = ["--seconds", "2"];
    let (model, rig) = both(&python, "examples/opensees/frame.py", &words, server);
    assert_eq!(rig["verdict"], "completed", "{rig}");
    assert_eq!(rig["permit"], false);
    assert_eq!(rig["targets"], 200);
    let board = &rig["board"];
    assert_eq!(board["steps_lost"], 0, "{rig}");
    assert_eq!(board["steps_different"], 0, "every bit is worked out again");
    assert!(board["steps_received"].as_u64().unwrap() > 40_000, "{rig}");
    assert_eq!(board["timing"]["overruns"], 0);
    // The brace yields; converters of 12 bits and a compensated delay leave a few per cent.
    assert!(model["peak_m"].as_f64().unwrap() > 0.008, "{model}");
    assert!(model["eps_rms"].as_f64().unwrap() < 0.03, "{model}");
    let energy = rig["energy_ratio"].as_f64().unwrap();
    assert!(energy.abs() < 0.1, "{rig}");
    let report = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    for words in ["energy error", "measured less target", "NUCLEO-F429ZI"] {
        assert!(report.contains(words), "{words}");
    }
}
