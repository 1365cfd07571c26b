//! The servo-hydraulic actuator against what its hydraulics allow.

use crate::common::{RATE_HZ, STIFFNESS, run, spec};
use plant::Rig;

#[test]
fn its_velocity_is_limited_by_the_valve() {
    let table = "actuator = { kind = 'servo_hydraulic', delay_ms = 10, servo = { velocity_limit_mm_per_s = 200, force_limit_n = 1e8 } }";
    let rows = run(&spec(table), 0.5, |_| 0.08);
    let velocity = (rows[400].displacement - rows[200].displacement) / 0.1;
    assert!((velocity - 0.2).abs() < 0.002, "{velocity} m/s");
    assert!((rows[999].displacement - 0.08).abs() < 1e-4);
}

#[test]
fn it_stalls_at_its_force() {
    let table =
        "actuator = { kind = 'servo_hydraulic', delay_ms = 10, servo = { force_limit_n = 5000 } }";
    let rows = run(&spec(table), 3.0, |_| 0.1); // would take 15.8 kN
    let last = rows[rows.len() - 1];
    assert!(
        (last.true_force - 5000.0).abs() < 50.0,
        "{} N",
        last.true_force
    );
    assert!(
        rows.iter().all(|r| r.true_force < 5600.0),
        "inertia of the piston apart"
    );
}

#[test]
fn the_oil_column_rings_at_its_frequency() {
    // Softly sprung oil, a slow loop, a step of the command: the velocity rings at the frequency of mass on oil and
    // specimen, sqrt(1 + K / ko) above that of the oil alone.
    let table = "actuator = { kind = 'servo_hydraulic', delay_ms = 100, servo = { oil_column_hz = 30, oil_column_zeta = 0.05, piston_mass_kg = 100 } }";
    let rows = run(&spec(table), 0.6, |_| 0.001);
    let velocity: Vec<f64> = rows
        .windows(2)
        .map(|w| w[1].displacement - w[0].displacement)
        .collect();
    let curvature: Vec<f64> = velocity.windows(2).map(|w| w[1] - w[0]).collect();
    let crossings: Vec<usize> = (100..curvature.len() - 1)
        .filter(|i| curvature[*i] < 0.0 && curvature[i + 1] >= 0.0)
        .collect();
    let n = crossings.len() - 1;
    let hz = RATE_HZ * n as f64 / (crossings[n] - crossings[0]) as f64;
    let oil = 100.0 * (std::f64::consts::TAU * 30.0).powi(2);
    let expected = 30.0 * (1.0 + STIFFNESS / oil).sqrt();
    assert!(
        (hz / expected - 1.0).abs() < 0.02,
        "{hz} Hz, expected {expected} Hz"
    );
}

#[test]
fn a_finer_time_step_gives_the_same_motion() {
    let table = "actuator = { kind = 'servo_hydraulic', delay_ms = 10, servo = { velocity_limit_mm_per_s = 900, force_limit_n = 20e3 } }";
    let spec = spec(table);
    let motion = |rate: f64| {
        let mut rig = Rig::new(&spec, &[STIFFNESS], rate, 0).unwrap();
        let every = (rate / 500.0) as usize;
        (0..500 * every)
            .map(|i| {
                // The same staircase of commands at any rate.
                let t = (i / every) as f64 / 500.0;
                rig.step(&[0.05 * (9.0 * t).sin()]).true_displacement_m[0]
            })
            .skip(every - 1)
            .step_by(every)
            .collect::<Vec<_>>()
    };
    let (coarse, fine) = (motion(1000.0), motion(16_000.0));
    let worst = coarse
        .iter()
        .zip(&fine)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(worst < 2e-5 * 0.05, "{worst} m");
}

#[test]
fn a_loop_that_the_oil_column_makes_unstable_is_refused() {
    let build = |delay_ms: f64| {
        let table = format!(
            "actuator = {{ kind = 'servo_hydraulic', delay_ms = {delay_ms}, servo = {{ oil_column_hz = 40, oil_column_zeta = 0.1 }} }}"
        );
        Rig::new(&spec(&table), &[STIFFNESS], RATE_HZ, 0).map(drop)
    };
    // Without the valve's own lag the limit would be kv = 2 z w = 50 /s; it costs a little more.
    assert!(build(30.0).is_ok());
    let refused = build(15.0).unwrap_err();
    assert_eq!(refused.path, "plant.actuator.delay_ms");
    assert_eq!(refused.value, "15");
}
