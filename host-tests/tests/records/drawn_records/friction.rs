//! Specimens that rub.

use super::{ANY, Bristles, Drawn, FRICTION, assert_has, right, said};
use host_tests::outside::Case;
use plant::Effect;
use std::f64::consts::TAU;

/// Beside `emps`: a carriage in a position loop that goes from point to point.
pub(super) fn axis(folder: &str) -> Case {
    const MOVE_S: f64 = 1.2;
    const POINTS_MM: [f64; 9] = [0.0, 130.0, 30.0, 190.0, 110.0, 220.0, 60.0, 150.0, 10.0];
    let mut drawn = Drawn::new(folder);
    let (mut x, mut v, mut rubs) = (0.0, 0.0, Bristles::new(0.02));
    let wanted = |t: f64| {
        let u = t.max(0.0) / MOVE_S;
        let (i, u) = (u as usize, u.fract());
        let way = POINTS_MM[(i + 1) % 9] - POINTS_MM[i % 9];
        let place = POINTS_MM[i % 9] + way * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u);
        [place, way * 30.0 * (u * (1.0 - u)).powi(2) / MOVE_S]
    };
    let columns = "command_mm,displacement_mm,force_n";
    drawn.record(
        ["axis.csv", columns],
        500.0,
        [0.0, 24.0],
        [0.0, 2e-4, 0.3],
        |t, dt| {
            let [r, speed] = wanted(t);
            let force = 530.0 * (r - x) + 8.0 * (speed - v);
            let row = [r, x, force];
            let held = 18.0 * rubs.slide(v * dt);
            v += dt * 1e3 / 60.0 * (force - 0.15 * v - held + 2.5);
            x += dt * v;
            row
        },
    );
    let declared = [
        ("stiffness_n_per_mm", [0.0, 1e-4]),
        ("damping_n_s_per_mm", [0.16, 0.02]),
        ("mass_kg", [59.0, 2.0]),
        ("offset_n", [-2.0, 1.0]),
    ];
    let spans: [&[&str]; 2] = [&["axis.csv@0..12.4"], &["axis.csv@12.4..23.99"]];
    drawn.case(
        "specimen",
        &declared,
        spans,
        [&["effect", "partial"], &FRICTION],
        0.05,
    )
}

#[test]
fn a_drawn_axis_has_the_parameters_it_was_drawn_with() {
    let a = right(&axis("axis"));
    assert_eq!(a.effects[0].name, Effect::CoulombFriction, "{}", said(&a));
    assert_has(&a, "force_n", 18.0, 0.02);
    assert_has(&a, "mass_kg", 60.0, 0.01);
    assert_has(&a, "damping_n_s_per_mm", 0.15, 0.03);
    assert_has(&a, "offset_n", -2.5, 0.06);
}

/// Strokes out and back, one after another, mm and mm/s.
fn strokes(t: f64, speeds: &[f64]) -> [f64; 2] {
    let mut left = t.max(0.0);
    for i in 0.. {
        let (speed, out) = (speeds[i / 2 % speeds.len()], i % 2 == 0);
        if left * speed < 20.0 {
            let (x, v) = if out {
                (left * speed, speed)
            } else {
                (20.0 - left * speed, -speed)
            };
            return [x, v];
        }
        left -= 20.0 / speed;
    }
    unreachable!()
}

/// Beside the seals: they rub, with a little give and grease, and the stamps are uneven.
fn seal(name: &str, seconds: f64, speeds: &[f64]) -> Drawn {
    let mut drawn = Drawn::new(name);
    let (mut rubs, mut last, mut late) = (Bristles::new(0.1), 0.0, 0_u32);
    let file = ["seal.csv", "displacement_mm,force_n"];
    drawn.record(file, 100.0, [0.0, seconds], [2e-3, 0.15], |t, _| {
        let [x, v] = strokes(t, speeds);
        let held = 7.0 * rubs.slide(x - last);
        last = x;
        [x, 2.4 + 0.02 * v + held]
    });
    let text = std::fs::read_to_string(drawn.folder.join("seal.csv")).unwrap();
    let uneven = |line: &str| match line.split_once(',') {
        Some((stamp, rest)) if stamp.parse::<f64>().is_ok() => {
            late += 1;
            let moved = 4e-4 * (f64::from(late) * 0.618).fract();
            format!("{:.5},{rest}\n", stamp.parse::<f64>().unwrap() + moved)
        }
        _ => format!("{line}\n"),
    };
    drawn.write("seal.csv", &text.lines().map(uneven).collect::<String>());
    drawn
}

const SEAL: [(&str, [f64; 2]); 4] = [
    ("stiffness_n_per_mm", [0.0, 0.02]),
    ("damping_n_s_per_mm", [0.0, 0.05]),
    ("mass_kg", [0.0, 0.1]),
    ("offset_n", [3.0, 2.0]),
];

#[test]
fn a_drawn_seal_rubs() {
    let drawn = seal("seal", 54.0, &[5.0, 12.0, 8.0, 20.0]);
    let spans: [&[&str]; 2] = [&["seal.csv@0..33"], &["seal.csv@33.2..53.9"]];
    let a = right(&drawn.case("specimen", &SEAL, spans, [&ANY, &FRICTION], 0.05));
    assert_has(&a, "force_n", 7.0, 0.02);
    assert!(
        a.error_after.test_rms < 0.1 * a.error_before.test_rms,
        "{}",
        said(&a)
    );
}

#[test]
fn strokes_of_one_speed_and_direction_say_no_single_name() {
    let drawn = seal("one-way", 72.0, &[5.0]);
    let train =
        [0.0, 8.0, 16.0, 24.0, 32.0].map(|at| format!("seal.csv@{}..{}", at + 0.1, at + 3.9));
    let test = [40.0, 48.0, 56.0, 64.0].map(|at| format!("seal.csv@{}..{}", at + 0.1, at + 3.9));
    let [train, test] =
        [&train[..], &test].map(|all| all.iter().map(String::as_str).collect::<Vec<_>>());
    let mut blank = SEAL;
    blank[3].1 = [0.0, 2.0];
    blank[1].1 = [0.0, 0.1];
    right(&drawn.case(
        "specimen",
        &blank,
        [&train, &test],
        [&["ambiguous"], &FRICTION],
        0.8,
    ));
}

/// Beside the friction damper: a band brake behind the slack of its linkage.
#[test]
fn a_drawn_brake_behind_slack_slides() {
    let mut drawn = Drawn::new("brake");
    let (mut rubs, mut at) = (Bristles::new(0.8), 0.0_f64);
    let columns = "displacement_mm,force_n";
    drawn.record(
        ["brake.csv", columns],
        256.0,
        [0.0, 16.0],
        [2e-3, 30.0],
        |t, _| {
            let x = 13.0 * (t / 2.0).min(1.0) * (TAU * 0.5 * t).sin();
            let next = at.clamp(x - 0.7, x + 0.7);
            let held = 6.5e3 * rubs.slide(next - at);
            at = next;
            [x, held]
        },
    );
    let declared = [
        ("stiffness_n_per_mm", [0.0, 10.0]),
        ("damping_n_s_per_mm", [0.0, 2.0]),
        ("mass_kg", [0.0, 10.0]),
        ("offset_n", [0.0, 300.0]),
    ];
    let spans: [&[&str]; 2] = [&["brake.csv@0..9"], &["brake.csv@9..15.9"]];
    let names = [
        "coulomb_friction",
        "bilinear_hysteresis",
        "bouc_wen_hysteresis",
    ];
    right(&drawn.case("specimen", &declared, spans, [&ANY, &names], 0.1));
}
