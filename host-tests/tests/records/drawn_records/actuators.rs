//! Actuators, and the channels around them.

use super::super::other_channels::{found, testimony};
use super::super::real_records::shift_mm;
use super::{ANY, Bristles, Drawn, FRICTION, LATE, assert_has, right, said, tones};
use diagnosis::{Says, Verdict};
use plant::Effect;

/// Beside `cable_jaw`.
#[test]
fn a_drawn_slack_is_a_play_of_its_width_or_friction() {
    let mut drawn = Drawn::new("slack");
    let (mut lagged, mut at) = (0.0, 0.0_f64);
    drawn.record(
        ["slack.csv", "command_mm,displacement_mm"],
        250.0,
        [5.0, 20.0],
        [0.0, 5e-3],
        |t, dt| {
            let [u, ..] = tones(&[0.4, 0.93], 20.0, t);
            lagged += dt / 0.01 * (0.86 * u - lagged);
            at = at.clamp(lagged - 0.4, lagged + 0.4);
            [u, at]
        },
    );
    let declared = [
        ("gain", [0.865, 0.01]),
        ("delay_ms", [0.0, 4.0]),
        ("lag_ms", [10.0, 10.0]),
        ("offset_mm", [0.0, 0.5]),
    ];
    let spans: [&[&str]; 2] = [&["slack.csv@0..12"], &["slack.csv@12.1..19.9"]];
    let names = ["backlash", "coulomb_friction", "stribeck_friction"];
    let a = right(&drawn.case("actuator", &declared, spans, [&ANY, &names], 0.004));
    assert!(
        a.error_after.test_rms < 0.2 * a.error_before.test_rms,
        "{}",
        said(&a)
    );
}

/// Beside `table_two_transducers`, and what the rig watch says of it.
#[test]
fn the_second_of_two_drawn_transducers_is_late_by_what_it_is() {
    let mut drawn = Drawn::new("late");
    drawn.record(
        ["late.csv", "command_mm,displacement_mm"],
        200.0,
        [0.0, 50.0],
        [2e-3; 2],
        |t, _| {
            let hz = [0.31, 0.87, 1.9, 3.3];
            [
                tones(&hz, 15.0, t)[0],
                0.99 * tones(&hz, 15.0, t - 2.6e-3)[0] - 9.0,
            ]
        },
    );
    let declared = [
        ("gain", [0.99, 5e-3]),
        ("delay_ms", [0.0, 0.1]),
        ("lag_ms", [0.0, 0.1]),
        ("offset_mm", [-9.0, 0.1]),
    ];
    let spans: [&[&str]; 2] = [&["late.csv@0..28"], &["late.csv@28..49.9"]];
    let case = drawn.case("actuator", &declared, spans, [&ANY, &LATE], 0.001);
    right(&case);
    let report = case.watched().unwrap();
    let last = &report.events.last().unwrap().set[0];
    assert_eq!((last.name, last.side), ("delay_error", "actuator"));
    assert!((last.value - 2.6).abs() < 0.1, "{report:?}");
    assert_eq!(report.diagnosis.unwrap().agrees, Some(true));
}

/// Beside `mirror`.
#[test]
fn inputs_that_are_not_in_a_drawn_record_get_no_name() {
    let mut drawn = Drawn::new("unseen");
    let mut lagged = 0.0;
    drawn.record(
        ["unseen.csv", "command_mm,displacement_mm"],
        500.0,
        [1.0, 16.0],
        [0.0, 0.02],
        |t, dt| {
            let [u, ..] = tones(&[0.7, 1.9, 4.3, 7.1], 1.0, t);
            lagged += dt / 5e-3 * (u - lagged);
            let others = tones(&[0.9, 2.3, 3.7], 2.0, t)[0] + tones(&[1.3, 3.1, 5.3], 2.0, t)[0];
            [u, 3.0 * lagged + others]
        },
    );
    let declared = [
        ("gain", [3.0, 0.3]),
        ("delay_ms", [0.1, 0.1]),
        ("lag_ms", [5.0, 1.0]),
        ("offset_mm", [0.0, 0.2]),
    ];
    let spans: [&[&str]; 2] = [&["unseen.csv@0..8"], &["unseen.csv@8.01..15.9"]];
    right(&drawn.case("actuator", &declared, spans, [&["unknown"], &[]], 1.0));
}

/// Beside the servo-hydraulic actuator: a ram that is faster one way; `zero_mm` was set anew on the other day.
#[test]
fn a_drawn_ram_that_is_faster_one_way_is_named_unless_its_zero_is_of_another_day() {
    let mut drawn = Drawn::new("ram");
    let days = [
        ("noise.csv", [0.27, 0.71, 1.6, 3.1, 6.3], 0.0),
        ("chirp.csv", [0.21, 0.53, 1.1, 2.3, 4.9], 0.13),
    ];
    for (name, hz, zero_mm) in days {
        let mut x = 0.0;
        let columns = "command_mm,displacement_mm,force_n";
        drawn.record(
            [name, columns],
            250.0,
            [5.0, 46.8],
            [0.0, 2.6e-3, 10.0],
            |t, dt| {
                let e = tones(&hz, 6.0, t - 5e-3)[0] - x;
                x += dt * e / if e > 0.0 { 0.0205 } else { 0.0235 };
                [tones(&hz, 6.0, t)[0], x + zero_mm, 0.0]
            },
        );
    }
    let declared = [
        ("gain", [1.0, 0.02]),
        ("delay_ms", [5.0, 2.0]),
        ("lag_ms", [22.0, 3.0]),
        ("offset_mm", [0.0, 0.1]),
    ];
    let spans: [&[&str]; 2] = [&["noise.csv@0..28"], &["noise.csv@28.001..46.7"]];
    let names = ["asymmetric_actuator"];
    let case = drawn.case(
        "actuator",
        &declared,
        spans,
        [&["effect", "partial"], &names],
        0.003,
    );
    let a = right(&case);
    assert!(
        a.error_after.test_rms < 0.6 * a.error_before.test_rms,
        "{}",
        said(&a)
    );
    assert!(
        (a.noise_floor_rms / 2.6e-3 - 1.0).abs() < 0.2,
        "{}",
        said(&a)
    );
    assert_has(&a, "gain", 1.0, 0.005);
    assert_has(&a, "delay_ms", 5.0, 0.1);
    assert_has(&a, "lag_ms", 21.9, 0.04);
    let (a, _) = case
        .between(&["chirp.csv".into()], &["noise.csv".into()])
        .unwrap();
    println!("{}", said(&a));
    assert_eq!(a.verdict, Verdict::Unknown, "{}", said(&a));
}

/// Beside the rests of the servo-hydraulic actuator: the shift of a ram that is faster one way comes and goes with its motion, and is
/// taken neither for an offset nor for a drift.
#[test]
fn the_rests_of_a_drawn_ram_say_that_its_shift_is_of_motion() {
    let mut drawn = Drawn::new("resting_ram");
    let moves = |t: f64| ((t - 3.0).min(43.0 - t) / 2.0).clamp(0.0, 1.0);
    let wanted = |t: f64| moves(t) * tones(&[0.27, 0.71, 1.6, 3.1, 6.3], 6.0, t)[0];
    let (mut x, mut behind_mm, mut steps) = (0.0, 0.0, 0.0);
    drawn.record(
        ["ram.csv", "command_mm,displacement_mm"],
        250.0,
        [1.0, 46.8],
        [0.0, 2.6e-3],
        |t, dt| {
            let e: f64 = wanted(t - 5e-3) - x;
            x += dt * e / if e > 0.0 { 0.0205 } else { 0.0235 };
            if (2.9..43.5).contains(&t) {
                (behind_mm, steps) = (behind_mm + e.abs(), steps + 1.0);
            }
            [wanted(t), x]
        },
    );
    let declared = [
        ("gain", [1.0, 0.02]),
        ("delay_ms", [5.0, 2.0]),
        ("lag_ms", [22.0, 3.0]),
        ("offset_mm", [0.0, 0.1]),
    ];
    let spans: [&[&str]; 2] = [&["ram.csv@0..26"], &["ram.csv@26..46.7"]];
    let names = ["asymmetric_actuator"];
    let case = drawn.case(
        "actuator",
        &declared,
        spans,
        [&["effect", "partial"], &names],
        0.003,
    );
    let (whole, _) = case.held_out().unwrap();
    let spans = [[0.0, 2.9], [2.9, 43.5], [43.5, 46.7]];
    let shifts = spans.map(|[from, to]| shift_mm(whole.span(from, to)).unwrap());
    // From rest to rest it goes as far up as down, so it is behind the command by shares that are as the two times.
    let difference = (0.0235 - 0.0205) / (0.0235 + 0.0205);
    let by_law = behind_mm / steps * difference;
    println!("{shifts:.4?} mm before, in motion, after; by its law {by_law:.4}");
    assert!(
        shifts[0].abs() < 1e-3 && shifts[2].abs() < 1e-3,
        "{shifts:?}"
    );
    assert!(
        (shifts[1] / by_law - 1.0).abs() < 0.05,
        "{shifts:?} {by_law}"
    );
    let a = right(&case);
    assert_has(&a, "flow_difference", difference, 0.05);
    let offset = a.refitted.iter().find(|r| r.name == "offset_mm");
    assert!(
        offset.is_some_and(|r| r.value.abs() < 0.1 * by_law),
        "{}",
        said(&a)
    );
}

/// Beside `table_two_transducers`: the second transducer is late and reads less one way.
#[test]
fn asymmetry_next_to_a_drawn_late_transducer_is_named() {
    let mut drawn = Drawn::new("late_and_uneven");
    drawn.record(
        ["uneven.csv", "command_mm,displacement_mm"],
        200.0,
        [0.0, 50.0],
        [2e-3; 2],
        |t, _| {
            let hz = [0.31, 0.87, 1.9, 3.3];
            let [late, ..] = tones(&hz, 15.0, t - 2.6e-3);
            [tones(&hz, 15.0, t)[0], (0.99 + 0.01 * late.signum()) * late]
        },
    );
    let declared = [
        ("gain", [0.99, 5e-3]),
        ("delay_ms", [0.0, 0.1]),
        ("lag_ms", [0.0, 0.1]),
        ("offset_mm", [0.0, 0.1]),
    ];
    let spans: [&[&str]; 2] = [&["uneven.csv@0..28"], &["uneven.csv@28..49.9"]];
    let names = [
        "asymmetric_actuator",
        "delay_error",
        "lag_error",
        "second_lag",
        "oil_column",
    ];
    let a = right(&drawn.case("actuator", &declared, spans, [&ANY, &names], 0.001));
    let uneven = a
        .effects
        .iter()
        .find(|e| e.name == Effect::AsymmetricActuator);
    assert!(
        uneven.and_then(|e| e.p).is_some_and(|p| p > 0.9),
        "{}",
        said(&a)
    );
}

/// Beside the servo-hydraulic actuator, whose seals rub as well: what the asymmetry leaves.
#[test]
fn a_drawn_ram_that_is_faster_one_way_and_rubs_is_not_said_to_be_asymmetric_alone() {
    let mut drawn = Drawn::new("rubbing_ram");
    let (mut x, mut rubs) = (0.0, Bristles::new(0.05));
    drawn.record(
        ["ram.csv", "command_mm,displacement_mm"],
        250.0,
        [5.0, 46.8],
        [0.0, 2.6e-3],
        |t, dt| {
            let hz = [0.27, 0.71, 1.6, 3.1, 6.3];
            let e = tones(&hz, 6.0, t - 5e-3)[0] - x;
            let way = dt * e / if e > 0.0 { 0.0205 } else { 0.0235 };
            x += way;
            [tones(&hz, 6.0, t)[0], x - 0.03 * rubs.slide(way)]
        },
    );
    let declared = [
        ("gain", [1.0, 0.02]),
        ("delay_ms", [5.0, 2.0]),
        ("lag_ms", [22.0, 3.0]),
        ("offset_mm", [0.0, 0.1]),
    ];
    let spans: [&[&str]; 2] = [&["ram.csv@0..28"], &["ram.csv@28.001..46.7"]];
    let names = [
        "asymmetric_actuator",
        "coulomb_friction",
        "stribeck_friction",
    ];
    let a = right(&drawn.case("actuator", &declared, spans, [&ANY, &names], 0.01));
    let rubs = a.effects.iter().any(|e| FRICTION.contains(&e.name.name()));
    assert!(rubs || a.verdict == Verdict::Partial, "{}", said(&a));
}

/// Beside the pressure of a shake table, whose friction holds it back.
#[test]
fn the_pressure_of_a_drawn_table_shows_its_friction_and_no_asymmetry() {
    let mut drawn = Drawn::new("table");
    let (mut x, mut rubs) = (0.0, Bristles::new(0.1));
    let columns = "command_mm,displacement_mm,force_1";
    drawn.record(
        ["table.csv", columns],
        204.8,
        [5.0, 72.0],
        [0.0, 2e-3, 0.05],
        |t, _| {
            let hz = [0.31, 0.83, 1.7, 2.9, 4.1];
            let [late, _, a] = tones(&hz, 8.0, t - 5.5e-3);
            // Bisection for the place where the bristles hold the spring of the oil.
            let (mut low, mut high) = (x - 2.0, x + 2.0);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                let here = middle + 0.15 * rubs.after(middle - x);
                (low, high) = if here < late {
                    (middle, high)
                } else {
                    (low, middle)
                };
            }
            let pressure = rubs.slide(low - x) + 2e-4 * a;
            x = low;
            [tones(&hz, 8.0, t)[0], x, pressure]
        },
    );
    let declared = [
        ("gain", [1.0, 0.01]),
        ("delay_ms", [5.0, 1.0]),
        ("lag_ms", [0.5, 0.5]),
        ("offset_mm", [0.0, 0.05]),
    ];
    let spans = ["table.csv@0..45", "table.csv@45..71.9"];
    let both: [&[&str]; 2] = [&spans[..1], &spans[1..]];
    drawn.case("actuator", &declared, both, [&ANY, &FRICTION], 0.1);
    let told = found(&drawn.folder, "model.toml", spans, false);
    let (heard, of) = testimony(&drawn.folder, "table.csv", &told);
    assert_eq!(heard.says, Says::For);
    assert!(matches!(
        heard.name,
        Effect::CoulombFriction | Effect::Backlash
    ));
    // Any law of the command takes some of it, since here nothing but friction keeps the displacement from the command.
    let shares = [Effect::CoulombFriction, Effect::AsymmetricActuator].map(of);
    assert!(shares[0] > 0.9 && shares[1] < 0.5, "{shares:?}");
}
