//! Specimens that yield or lose energy.

use super::{Drawn, assert_has, right, said, tones};
use host_tests::outside::Case;
use plant::Effect;
use std::f64::consts::TAU;

/// Beside `bouc_wen`, and `coupon_2`: an element that yields smoothly beside a spring.
#[test]
fn a_drawn_element_that_yields_has_its_stiffness_and_its_exponent() {
    let mut drawn = Drawn::new("yields");
    let hz = [3.1, 5.3, 8.9, 14.3, 23.7];
    let mut z = 0.0_f64;
    drawn.record(
        ["yields.csv", "displacement_mm,force_n"],
        750.0,
        [2.0, 10.9],
        [2e-6, 0.05],
        |t, dt| {
            let [x, v, a] = tones(&hz, 1.2, t);
            z += dt * (35.0 * v - 1.4 * (0.6 * v.abs() * z + 0.4 * v * z.abs()));
            [x, 40.0 * x + 0.02 * v + 3e-3 * a + z]
        },
    );
    let declared = [
        ("stiffness_n_per_mm", [40.5, 1.0]),
        ("damping_n_s_per_mm", [0.02, 2e-3]),
        ("mass_kg", [3.0, 0.05]),
        ("offset_n", [0.0, 0.5]),
    ];
    let spans: [&[&str]; 2] = [&["yields.csv@0..6.5"], &["yields.csv@6.6..10.89"]];
    let names = ["bouc_wen_hysteresis"];
    let a = right(&drawn.case(
        "specimen",
        &declared,
        spans,
        [&["effect", "partial"], &names],
        0.02,
    ));
    assert_has(&a, "stiffness_n_per_mm", 35.0, 0.02);
    assert_has(&a, "exponent", 1.0, 0.02);
    assert_has(&a, "mass_kg", 3.0, 0.01);
}

/// Beside the magnetorheological damper.
#[test]
fn a_drawn_damper_at_one_frequency_has_a_set() {
    let mut drawn = Drawn::new("damper");
    drawn.record(
        ["damper.csv", "displacement_mm,force_n"],
        1000.0,
        [0.0, 11.66],
        [5e-4, 0.3],
        |t, _| {
            let (x, v) = (10.0 * (TAU * t).sin(), 10.0 * TAU * (TAU * t).cos());
            [x, 110.0 * (v / 14.0).tanh() + 0.6 * v]
        },
    );
    let declared = [
        ("damping_n_s_per_mm", [5.0, 5.0]),
        ("offset_n", [0.0, 50.0]),
    ];
    let spans: [&[&str]; 2] = [&["damper.csv@0..7"], &["damper.csv@7.001..11.65"]];
    let names = ["coulomb_friction"];
    let a = right(&drawn.case("specimen", &declared, spans, [&["ambiguous"], &names], 0.1));
    let set: Vec<Effect> = a.members.iter().map(|m| m.name).collect();
    assert!(set.contains(&Effect::ViscousDamping), "{}", said(&a));
    assert!(
        a.notes.iter().any(|n| n.contains("one frequency")),
        "{}",
        said(&a)
    );
    assert!(
        a.error_after.test_rms < 0.35 * a.error_before.test_rms,
        "{}",
        said(&a)
    );
}

/// Beside the beam in a fatigue rig.
pub(super) fn beam(folder: &str) -> Case {
    let mut drawn = Drawn::new(folder);
    drawn.record(
        ["beam.csv", "displacement_mm,force_1"],
        129.0,
        [0.0, 80.0],
        [1e-4, 4e-4],
        |t, _| {
            let [x, v, _] = tones(&[0.23, 0.61, 1.3, 2.9, 5.1], 0.6, t);
            [x, 0.55 * x + 0.02 * v]
        },
    );
    let declared = [
        ("stiffness_n_per_mm", [0.5, 0.5]),
        ("offset_n", [0.0, 0.05]),
    ];
    let spans: [&[&str]; 2] = [&["beam.csv@0..50"], &["beam.csv@50.01..79.9"]];
    let names = ["viscous_damping"];
    drawn.case(
        "specimen",
        &declared,
        spans,
        [&["effect", "partial"], &names],
        0.01,
    )
}

#[test]
fn a_drawn_loss_beside_a_spring_is_damping_of_its_size() {
    let a = right(&beam("beam"));
    assert_has(&a, "damping_n_s_per_mm", 0.02, 0.01);
    assert!(
        a.error_after.test_rms < 0.1 * a.error_before.test_rms,
        "{}",
        said(&a)
    );
}
