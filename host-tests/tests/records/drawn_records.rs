//! The figures of third-party records, bounded on records drawn here, so that a fork without the data still holds each
//! (`docs/validation.md` has the list). They are files of the same kinds, asked by the same calls. Their laws share nothing with
//! the diagnosis: friction is bristles (Dahl), in steps of an eighth of a sample.
#![cfg(not(debug_assertions))] // Minutes without optimisation.

use super::next_errors::they_hold;
use super::other_channels::{found, testimony};
use diagnosis::{ChannelAnswer, Says, Verdict};
use host_tests::foresight::{Pair, of_case};
use host_tests::outside::{Case, cases_in};
use plant::Effect;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Steps of a law to one of a record.
const STEPS: usize = 8;
const FRICTION: [&str; 2] = ["coulomb_friction", "stribeck_friction"];
const ANY: [&str; 3] = ["effect", "partial", "ambiguous"];
const LATE: [&str; 3] = ["delay_error", "lag_error", "second_lag"];

/// A folder of a record, its declared model and its answer, as a folder of third-party records.
struct Drawn {
    folder: PathBuf,
    random: Xoshiro256PlusPlus,
}

impl Drawn {
    fn new(name: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("drawn-records")
            .join(name);
        std::fs::create_dir_all(&folder).unwrap();
        let random = Xoshiro256PlusPlus::seed_from_u64(7);
        Self { folder, random }
    }

    fn noise(&mut self, rms: f64) -> f64 {
        rms * Distribution::<f64>::sample(&StandardNormal, &mut self.random)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.folder.join(name), text).unwrap();
    }

    /// A file of a record; `row` is called every `1 / (STEPS rate_hz)` from `before_s` on, and its last before each sample counts.
    fn record<const N: usize>(
        &mut self,
        [name, columns]: [&str; 2],
        rate_hz: f64,
        [before_s, seconds]: [f64; 2],
        noise: [f64; N],
        mut row: impl FnMut(f64, f64) -> [f64; N],
    ) {
        let mut text = format!("# drawn\ntime_s,{columns}\n");
        let dt = 1.0 / (STEPS as f64 * rate_hz);
        for i in (-before_s * rate_hz) as i64..(seconds * rate_hz) as i64 {
            let step = |k: usize| (i as f64 - (STEPS - 1 - k) as f64 / STEPS as f64) / rate_hz;
            let read = (0..STEPS).map(|k| row(step(k), dt)).last().unwrap();
            if i < 0 {
                continue;
            }
            let _ = write!(text, "{:.7}", i as f64 / rate_hz);
            for (signal, rms) in read.into_iter().zip(noise) {
                let _ = write!(text, ",{:.7}", signal + self.noise(rms));
            }
            text.push('\n');
        }
        self.write(name, &text);
    }

    /// The case of these spans: declared values with their tolerances, right names, and the error that is right.
    fn case(
        &self,
        channel: &str,
        declared: &[(&str, [f64; 2])],
        [train, test]: [&[&str]; 2],
        [verdicts, names]: [&[&str]; 2],
        after_nrmse: f64,
    ) -> Case {
        let mut model = format!("[{channel}]\n");
        for (key, [value, tolerance]) in declared {
            let _ = writeln!(
                model,
                "{key} = {{ value = {value:?}, tolerance = {tolerance:?} }}"
            );
        }
        self.write("model.toml", &model);
        self.write(
            "cases.toml",
            &format!(
                "[[case]]\nid = \"drawn\"\nchannel = {channel:?}\nmodel = \"model.toml\"\ntrain = {train:?}\ntest = {test:?}\n\
                 rest = []\nverdicts = {verdicts:?}\nnames = {names:?}\nhalf = []\nset_must_hold_one_of = {names:?}\nnever = []\n\
                 cause = \"drawn\"\nreference = {{ before_nrmse = 1.0, after_nrmse = {after_nrmse:?} }}\n"
            ),
        );
        cases_in(&self.folder).unwrap().remove(0)
    }
}

/// The answer, which must be right by the rules of third-party records, and without a wrong name.
#[track_caller]
fn right(case: &Case) -> ChannelAnswer {
    let (answer, _) = case.diagnose().unwrap();
    println!("{}", said(&answer));
    assert_eq!(case.points(&answer), 1.0, "{}", said(&answer));
    let of_case = |name: &str| case.names.iter().any(|n| n == name);
    let is_set = answer.verdict == Verdict::Ambiguous;
    let no_other = is_set || answer.effects.iter().all(|e| of_case(e.name.name()));
    assert!(no_other, "{}", said(&answer));
    answer
}

fn said(a: &ChannelAnswer) -> String {
    let effects = a.effects.iter();
    let named: Vec<_> = effects
        .map(|e| {
            (
                e.name,
                e.q,
                e.parameters
                    .iter()
                    .map(|p| (p.name.as_str(), p.value))
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    let set: Vec<_> = a.members.iter().map(|m| m.name).collect();
    let refitted: Vec<_> = a
        .refitted
        .iter()
        .map(|r| (r.name.as_str(), r.value))
        .collect();
    format!(
        "{:?} {named:?}, set {set:?}, nearest {:?}; refitted {refitted:?}; {:.5} -> {:.5}, noise {:.5}; {:?}",
        a.verdict,
        a.nearest,
        a.error_before.test_nrmse,
        a.error_after.test_nrmse,
        a.noise_floor_rms,
        a.notes
    )
}

/// A figure of the first name, or a refitted one, within a share.
#[track_caller]
fn assert_has(a: &ChannelAnswer, figure: &str, value: f64, within: f64) {
    let own = a.effects.iter().flat_map(|e| &e.parameters);
    let own = own.filter(|p| p.name == figure).map(|p| p.value);
    let refitted = a
        .refitted
        .iter()
        .filter(|r| r.name == figure)
        .map(|r| r.value);
    let is = own.chain(refitted).next();
    let close = is.is_some_and(|is| (is / value - 1.0).abs() < within);
    assert!(close, "{figure} {value}: {}", said(a));
}

/// Sines of an amplitude that falls with their frequency: place, mm, and its first two derivatives.
fn tones(hz: &[f64], size_mm: f64, t: f64) -> [f64; 3] {
    let (mut sum, lowest) = ([0.0; 3], hz[0]);
    for (k, hz) in hz.iter().enumerate() {
        let (w, size) = (TAU * hz, size_mm / (1.0 + hz / lowest));
        let phase = w * t + 1.7 * (k * k) as f64;
        sum[0] += size * phase.sin();
        sum[1] += size * w * phase.cos();
        sum[2] -= size * w * w * phase.sin();
    }
    sum
}

/// Bristles that give by a way before they slide: from -1 to 1.
struct Bristles {
    bent: f64,
    give_mm: f64,
}

impl Bristles {
    fn new(give_mm: f64) -> Self {
        Self { bent: 0.0, give_mm }
    }

    fn after(&self, way: f64) -> f64 {
        way.signum() + (self.bent - way.signum()) * (-way.abs() / self.give_mm).exp()
    }

    fn slide(&mut self, way: f64) -> f64 {
        self.bent = self.after(way);
        self.bent
    }
}

/// Beside `emps`: a carriage in a position loop that goes from point to point.
fn axis(folder: &str) -> Case {
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
fn beam(folder: &str) -> Case {
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

/// Beside the pairs of open records whose next error was predicted, by the same shares.
#[test]
fn foretold_errors_hold_on_drawn_records() {
    let pairs: Vec<Pair> = [axis("axis-next"), beam("beam-next")]
        .iter()
        .flat_map(of_case)
        .collect();
    assert_eq!(pairs.len(), 8);
    they_hold(&pairs);
}
