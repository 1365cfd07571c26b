//! One test over the values of a key, and on drawn rigs.

use super::EXAMPLE;
use crate::common::{json, json_with, outerloop, refused};

#[test]
fn a_sweep_has_the_figures_of_each_test() {
    let over = "coupled.actuators.slow_pole_hz.0=2.65,2.8";
    let compensations = "coupled-fixed,coupled";
    let said = json(&[
        "sweep",
        EXAMPLE,
        "--duration",
        "8",
        "--over",
        over,
        "--compensations",
        compensations,
        "--json",
    ]);
    let rows = said["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    let alone = json(&["run", EXAMPLE, "--duration", "8", "--json"]);
    let coupled = &rows[1];
    assert_eq!(coupled["compensation"], "coupled");
    for key in ["eps_rms", "eps_max", "verdict", "peak_displacement_m"] {
        assert_eq!(coupled[key], alone[key], "{key}");
    }
    let error = |row: usize| rows[row]["eps_rms"].as_f64().unwrap();
    // If the pole is declared correctly, it need not be identified; both are then nearer.
    assert!(error(2) < 0.8 * error(0), "{} {}", error(2), error(0));
    refused(
        &["sweep", EXAMPLE, "--over", over, "--compensations", "paper"],
        &["paper", "coupled-fixed"],
    );
}

/// Without noise the tests are those of the check: the same rigs, and each with its own ideal.
#[test]
fn drawn_rigs_are_those_of_the_check_and_say_by_what_they_differ() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let quiet = [
        "--json",
        "--set",
        "plant.sensors.displacement_noise_mm=0",
        "--set",
        "plant.sensors.force_noise_n=0",
        "--set",
        "coupled.compensation=coupled-fixed",
        "--set",
        "coupled.specimen.damping=[[200,0],[0,100]]",
        "--set",
        "excitation={scale=0.2,duration_s=8}",
    ];
    let drawn = ["sweep", EXAMPLE, "--drawn", "5", "--out", out];
    let swept = json(&[&drawn[..], &quiet[..]].concat());
    assert_eq!(swept["tests"], 5);
    assert_eq!(swept["completed"], 5);
    let check = outerloop(&[&["check", EXAMPLE, "--plants", "5"][..], &quiet[..]].concat());
    let check: serde_json::Value = serde_json::from_slice(&check.stdout).unwrap();
    assert_eq!(check["lost"], 0);
    assert_eq!(swept["eps_rms_worst"], check["drawn_eps_rms"]);
    let text = std::fs::read_to_string(folder.path().join("tests.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
    assert_eq!(rows.len(), 6);
    // A zero of a path that has none cannot differ, the gains of all four paths can.
    assert!(!text.contains("path_lead_ms.0.0") && text.contains("path_lead_ms.0.1_factor_1"));
    assert!(text.contains("gain.1.0_factor_1") && text.contains("specimen.damping_factor_1"));
    // The first rig once more, from the factors in its row.
    let factor = |name: &str| -> f64 {
        let column = format!("{name}_factor_1");
        let at = rows[0].iter().position(|c| *c == column).unwrap();
        rows[1][at].parse().unwrap()
    };
    let mut again = vec!["run".to_owned(), EXAMPLE.to_owned()];
    again.extend(quiet.map(str::to_owned));
    let two = |name: &str, of: [f64; 2]| [0, 1].map(|i| of[i] * factor(&format!("{name}.{i}")));
    let gain = |i: usize, of| two(&format!("gain.{i}"), of);
    let path = |i: usize, ms: f64| ms * factor(&format!("path_lead_ms.{i}.1"));
    let (k, c) = (factor("specimen.stiffness"), factor("specimen.damping"));
    for (key, value) in [
        (
            "actuators.slow_pole_hz",
            format!("{:?}", two("slow_pole_hz", [2.8, 3.3])),
        ),
        (
            "actuators.fast_pole_hz",
            format!("{:?}", two("fast_pole_hz", [40.0, 18.5])),
        ),
        (
            "actuators.delay_ms",
            format!("{:?}", two("delay_ms", [2.0, 2.0])),
        ),
        (
            "actuators.natural_hz",
            (80.0 * factor("natural_hz")).to_string(),
        ),
        (
            "actuators.path_lead_ms",
            format!("[[0,{}],[0,{}]]", path(0, 53.0), path(1, 32.0)),
        ),
        (
            "actuators.gain",
            format!(
                "[{:?},{:?}]",
                gain(0, [0.88, 0.128]),
                gain(1, [0.143, 0.91])
            ),
        ),
        (
            "specimen.stiffness",
            format!("[[{},{}],[{1},{}]]", 104e3 * k, 30e3 * k, 96e3 * k),
        ),
        (
            "specimen.damping",
            format!("[[{},0],[0,{}]]", 200.0 * c, 100.0 * c),
        ),
    ] {
        again.extend(["--set".to_owned(), format!("plant.coupled.{key}={value}")]);
    }
    let again: Vec<&str> = again.iter().map(String::as_str).collect();
    let alone = json_with(1, &again)["eps_rms"].as_f64().unwrap();
    let swept: f64 = rows[1][rows[1].len() - 2].parse().unwrap();
    assert!((swept / alone - 1.0).abs() < 1e-6, "{swept} {alone}");
    let page = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(page.contains("The worst of them") && page.contains("gain.1.0, of the declared"));
}
