//! Interlocks in both systems of coordinates, and refused test files.

use super::EXAMPLE;
use crate::common::{command, json_with, outerloop, refused};

#[test]
fn interlocks_act_in_both_systems_of_coordinates_and_say_which() {
    for (limit, fault, axis) in [
        ("stroke_m=0.02", "displacement", "actuator"),
        ("velocity_m_per_s=0.2", "velocity", "actuator"),
        ("force_n=500", "force", "actuator"),
        ("x_m=0.01", "displacement", "x"),
        ("x_velocity_m_per_s=0.1", "velocity", "x"),
        ("x_force_n=500", "force", "x"),
        ("x_tracking_m=0.00005", "tracking", "x"),
        ("rotation_rad=0.003", "displacement", "rotation"),
        ("rotation_velocity_rad_per_s=0.03", "velocity", "rotation"),
        ("moment_n_m=40", "force", "rotation"),
    ] {
        let set = format!("coupled.limits.{limit}");
        let said = json_with(1, &["run", EXAMPLE, "--json", "--set", &set]);
        assert_eq!(said["verdict"], "tripped", "{limit}");
        assert_eq!(said["trip"], fault, "{limit}");
        let of = said["trip_axis"].as_str().unwrap();
        assert!(of.starts_with(axis), "{limit}: {of}");
    }
}

#[test]
fn what_cannot_be_is_refused_in_one_sentence() {
    let set = |assignment: &str, words: &[&str]| {
        refused(&["run", EXAMPLE, "--set", assignment], words);
    };
    let set_emulated = |assignment: &str, words: &[&str]| {
        refused(&["run", EXAMPLE, "--emulated", "--set", assignment], words);
    };
    set(
        "coupled.structure.stiffness=[[1,2],[3,4]]",
        &["coupled.structure.stiffness", "symmetric"],
    );
    set(
        "coupled.structure.coordinates=[\"a_rad\",\"b_m\"]",
        &["coordinates", "first a displacement"],
    );
    set(
        "coupled.limits.force_n=0",
        &["coupled.limits.force_n = 0", "above 0"],
    );
    set(
        "coupled.coupler.pin_y_m=[0.1,0.1]",
        &["coupled.coupler.pin_y_m", "apart"],
    );
    set(
        "coupled.actuators.gain=[[1,1],[1,1]]",
        &["gain", "inverted"],
    );
    set(
        "coupled.actuators.delay_ms=[90,0]",
        &["delay", "60 sampling periods"],
    );
    set(
        "coupled.compensation=paper",
        &["compensation", "coupled-fixed"],
    );
    set(
        "plant.coupled.specimen.mass=[[1,2],[3,4]]",
        &["plant.coupled.specimen.mass", "symmetric"],
    );
    set("loop.time_scale=2", &["loop.time_scale", "real time"]);
    set("structure.mass_kg=1", &["structure", "beside [coupled]"]);
    let none = "two coupled actuators";
    refused(
        &["run", EXAMPLE, "--emulated", "--scope"],
        &["--scope", none],
    );
    set_emulated(
        "loop.rate_hz=1024",
        &["loop.rate_hz = 1024", "divisors of 84 MHz"],
    );
    let third = "coupled.structure={coordinates=['x_m','rotation_rad','top_m'],damping_ratio=0.04,\
                 mass=[[1000,0,0],[0,60,0],[0,0,500]],stiffness=[[208e3,60e3,0],[60e3,192e3,0],[0,0,1e5]]}";
    set_emulated(
        third,
        &[
            "coupled.structure.coordinates has 3 names",
            "accepted on a board are 2",
        ],
    );
    refused(
        &["improve", EXAMPLE],
        &["run, compare, check, sweep, serve"],
    );
    refused(
        &["run", EXAMPLE, "--compensation", "paper"],
        &["paper", "coupled-fixed"],
    );
    let output = command(&["new", "--from", "coupled-frame", "/dev/null"])
        .output()
        .unwrap();
    assert_eq!(
        output.status.code(),
        Some(2),
        "what is there is not overwritten"
    );
    assert!(String::from_utf8_lossy(&outerloop(&["keys"]).stdout).contains("coupled.limits"));
}
