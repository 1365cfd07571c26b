//! `outerloop sweep`: one row a test, the same figures as `run`, fragility curves, mistakes by name.

use crate::common::{json, outerloop, refused};

const TABLE1: &str = "examples/table1.toml";

#[test]
fn each_row_is_the_test_that_run_runs() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().to_str().unwrap();
    let over = "plant.actuator.delay_ms=0..8/3";
    let swept = json(&[
        "sweep",
        TABLE1,
        "--over",
        over,
        "--compensations",
        "none,paper",
        "--duration",
        "5",
        "--out",
        out,
        "--json",
    ]);
    let rows = swept["rows"].as_array().unwrap();
    let of: Vec<(f64, &str)> = rows
        .iter()
        .map(|r| {
            (
                r["value"].as_f64().unwrap(),
                r["compensation"].as_str().unwrap(),
            )
        })
        .collect();
    assert_eq!(
        of,
        [
            (0.0, "none"),
            (0.0, "paper"),
            (4.0, "none"),
            (4.0, "paper"),
            (8.0, "none"),
            (8.0, "paper")
        ]
    );
    let set = "plant.actuator.delay_ms=8";
    let alone = json(&["run", TABLE1, "--set", set, "--duration", "5", "--json"]);
    for key in ["eps_rms", "eps_max", "peak_displacement_m", "verdict"] {
        assert_eq!(rows[5][key], alone[key], "{key}");
    }
    let text = std::fs::read_to_string(folder.path().join("sweep.csv")).unwrap();
    assert_eq!(text.lines().count(), 7);
    let html = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(html.contains("<b>paper</b>") && html.contains("<svg"));
}

#[test]
fn a_fragility_curve_counts_what_the_rows_say() {
    // A linear structure: the peak is proportional to the scale, so where each motion exceeds the limit is known.
    let folder = tempfile::tempdir().unwrap();
    let motion = |name: &str, hz: f64| {
        let path = folder.path().join(name);
        let rows = (0..1000).map(|i| {
            let t = 0.01 * f64::from(i);
            format!(
                "{t:.2},{:.6}\n",
                0.02 * (std::f64::consts::TAU * hz * t).sin()
            )
        });
        let text = format!("time_s,acc_g\n{}", rows.collect::<String>());
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let files = [
        motion("a.csv", 1.0),
        motion("b.csv", 1.6),
        motion("c.csv", 1.8),
    ];
    let mut arguments = vec![
        "sweep",
        TABLE1,
        "--over",
        "excitation.scale=0.25..4/16",
        "--limit-mm",
        "5",
        "--json",
        "--compensations",
        "tangent",
    ];
    for file in &files {
        arguments.extend(["--record", file]);
    }
    let swept = json(&arguments);
    let rows = swept["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 48);
    let curves = swept["fragility"].as_array().unwrap();
    assert_eq!(
        (&curves[0]["of"], &curves[1]["of"]),
        (&"ideal".into(), &"tangent".into())
    );
    // Each motion exceeds the limit from 5 mm over its peak at scale 1 on.
    let at_one = rows.iter().filter(|r| r["value"] == 1.0);
    let mut from: Vec<f64> = at_one
        .map(|r| 5e-3 / r["ideal_peak_m"].as_f64().unwrap())
        .collect();
    from.sort_by(f64::total_cmp);
    for share in curves[0]["shares"].as_array().unwrap() {
        let value = share["value"].as_f64().unwrap();
        let expected = from.iter().filter(|f| value > **f).count();
        assert_eq!(share["beyond"], expected, "{share} {from:?}");
    }
    let fit = &curves[0]["fit"];
    let median = fit["median"].as_f64().unwrap();
    assert!(from[0] < median && median < from[2], "{median} of {from:?}");
    // Hardly any error in the test: the same curve.
    assert_eq!(fit, &curves[1]["fit"]);
}

#[test]
fn mistakes_are_named() {
    let over = |text| ["sweep", TABLE1, "--over", text];
    refused(&over("plant.actuator.delay_ms"), &["--over", "has no `=`"]);
    refused(&over("loop.rate=1,2"), &["loop.rate=1", "rate_hz"]);
    refused(
        &over("plant.actuator.delay_ms=-5..5/3"),
        &["plant.actuator.delay_ms", "-5"],
    );
    refused(&["sweep", TABLE1], &["--over", "missing"]);
    let limit = [&over("excitation.scale=1,2")[..], &["--limit-mm", "-1"]].concat();
    refused(&limit, &["--limit-mm", "-1"]);
    let lost = outerloop(&[
        "sweep",
        TABLE1,
        "--over",
        "plant.actuator.delay_ms=40,60",
        "--compensations",
        "none",
    ]);
    assert!(String::from_utf8_lossy(&lost.stdout).contains("lost"));
}
