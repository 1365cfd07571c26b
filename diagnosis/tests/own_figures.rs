//! Names whose own figures say something simpler, and names that specimens of other authors were given falsely: springs with a
//! textbook's force beside them, three seconds of rest at either end, two events.
#![allow(missing_docs)]

use diagnosis::{
    ChannelAnswer, Declared, Diagnosis, Model, Recording, SpecimenModel, Verdict, diagnose,
};
use plant::Effect;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;
use std::slice::from_ref;

const H: f64 = 1e-3;
/// Half of the displacement's range, mm.
const HALF_MM: f64 = 25.0;
const NOISE_N: f64 = 12.0;
const NOISE_MM: f64 = 4e-3;

/// Fourteen sines of 0.2 to 5 Hz between rests.
fn motion(seed: u64) -> Vec<f64> {
    let (n, rest_s) = (30_000, 3.0);
    let length = n as f64 * H;
    let at = |i: usize| {
        let t = i as f64 * H;
        let into = ((t - rest_s).min(length - rest_s - t) / 2.0).clamp(0.0, 1.0);
        let sines = (1..=14).map(|k| {
            let hz = 0.2 * 1.28_f64.powi(k - 1);
            let phase = 2.1 * f64::from(k * k) + 0.7 * (seed as f64) * f64::from(k);
            (TAU * hz * t + phase).sin() / (1.0 + hz)
        });
        into * into * (3.0 - 2.0 * into) * sines.sum::<f64>()
    };
    let x: Vec<f64> = (0..n).map(at).collect();
    let largest = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    x.iter().map(|x| HALF_MM * x / largest).collect()
}

/// Central differences, mm/s.
fn speed(x: &[f64]) -> Vec<f64> {
    let n = x.len();
    let at = |i: usize| (x[(i + 1).min(n - 1)] - x[i.saturating_sub(1)]) / (2.0 * H);
    (0..n).map(at).collect()
}

/// A record of a force of displacement (mm) and speed (mm/s); its noise is the amplifier's.
fn record(seed: u64, force: impl Fn(&[f64], &[f64]) -> Vec<f64>) -> Recording {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut noise = |rms: f64| rms * Distribution::<f64>::sample(&StandardNormal, &mut random);
    let x = motion(seed);
    let force: Vec<f64> = force(&x, &speed(&x))
        .iter()
        .map(|f| f + noise(NOISE_N))
        .collect();
    Recording {
        name: format!("event {seed}"),
        time_s: (0..x.len()).map(|i| i as f64 * H).collect(),
        displacement_mm: Some(x.iter().map(|x| x + noise(NOISE_MM)).collect()),
        force_n: Some(force),
        ..Recording::default()
    }
}

/// A spring of 1000 N/mm and a little damping, declared with these tolerances.
fn declared(stiffness: [f64; 2]) -> Model {
    let declared = |value, tolerance| Some(Declared { value, tolerance });
    Model {
        specimen: Some(SpecimenModel {
            stiffness_n_per_mm: declared(stiffness[0], stiffness[1]),
            damping_n_s_per_mm: declared(2.0, 2.0),
            mass_kg: declared(0.0, 2.0),
            offset_n: declared(0.0, 50.0),
            ..SpecimenModel::default()
        }),
        ..Model::default()
    }
}

fn asked(model: &Model, force: impl Fn(&[f64], &[f64]) -> Vec<f64>) -> (ChannelAnswer, Diagnosis) {
    let [train, test] = [1, 2].map(|seed| record(seed, &force));
    let found = diagnose(model, from_ref(&train), from_ref(&test), &[]).expect("an answer");
    let answer = found.channels[0].clone();
    println!("{}", said(&answer));
    (answer, found)
}

fn said(a: &ChannelAnswer) -> String {
    let figures = a.effects.iter().flat_map(|e| &e.parameters);
    let figures = figures.map(|p| format!("{} {:.3} {:.3?}", p.name, p.value, p.ci90));
    let names: Vec<(Effect, Option<f64>)> = a.effects.iter().map(|e| (e.name, e.q)).collect();
    format!(
        "{:?} {names:?} or {:?}; {:.1} -> {:.1}, noise {:.1}; {:?}; {:?}; {:?}",
        a.verdict,
        a.alternatives,
        a.error_before.test_rms,
        a.error_after.test_rms,
        a.noise_floor_rms,
        figures.collect::<Vec<_>>(),
        a.refitted,
        a.notes
    )
}

fn names(a: &ChannelAnswer) -> Vec<Effect> {
    a.effects.iter().map(|e| e.name).collect()
}

fn is_possible(a: &ChannelAnswer, name: Effect) -> bool {
    names(a).contains(&name) || a.alternatives.contains(&name)
}

/// Elastic, then it slides.
fn slider(x: &[f64], yield_mm: f64, force_n: f64) -> Vec<f64> {
    let (mut z, mut last) = (0.0_f64, x[0]);
    x.iter()
        .map(|x| {
            z = (z + x - last).clamp(-yield_mm, yield_mm);
            last = *x;
            force_n * z / yield_mm
        })
        .collect()
}

fn spring(x: &[f64], v: &[f64], stiffness: f64) -> Vec<f64> {
    x.iter()
        .zip(v)
        .map(|(x, v)| stiffness * x + 2.0 * v)
        .collect()
}

fn plus(mut a: Vec<f64>, b: &[f64]) -> Vec<f64> {
    a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
    a
}

#[test]
fn friction_on_a_softer_spring_does_not_fall_with_speed_and_the_spring_may_be_a_gain() {
    let (a, _) = asked(&declared([1000.0, 20.0]), |x, v| {
        plus(spring(x, v, 850.0), &slider(x, 0.02, 400.0))
    });
    assert!(is_possible(&a, Effect::CoulombFriction), "{}", said(&a));
    assert!(
        !names(&a).contains(&Effect::StribeckFriction),
        "{}",
        said(&a)
    );
    let soft = [Effect::GainError, Effect::RigCompliance];
    let named = soft.iter().filter(|n| names(&a).contains(*n)).count();
    let possible = soft.iter().filter(|n| is_possible(&a, **n)).count();
    // Neither, or both as a set.
    assert!(possible == 2 * named, "{}", said(&a));
}

#[test]
fn a_pair_is_saved_with_its_error() {
    let model = declared([1000.0, 20.0]);
    let force = |x: &[f64], v: &[f64]| {
        let cubic: Vec<f64> = x.iter().map(|x| 0.15 * x.powi(3)).collect();
        plus(spring(x, v, 850.0), &cubic)
    };
    let (first, found) = asked(&model, force);
    assert!(is_possible(&first, Effect::Hardening), "{}", said(&first));
    let (again, _) = asked(&found.improved, force);
    let [reported, saved] = [first.error_after.test_rms, again.error_before.test_rms];
    assert!(saved < 1.1 * reported, "{reported} N is {saved} N as saved");
}

#[test]
fn a_rocking_wall_gives_way_and_is_not_clipped() {
    for beyond in [10.0, 150.0] {
        let (a, _) = asked(&declared([1000.0, 50.0]), |x, v| {
            let bend = |x: &f64| (beyond - 1000.0) * (x - x.clamp(-8.0, 8.0));
            plus(
                spring(x, v, 1000.0),
                &x.iter().map(bend).collect::<Vec<_>>(),
            )
        });
        assert!(!names(&a).contains(&Effect::Saturation), "{}", said(&a));
        assert!(is_possible(&a, Effect::Softening), "{}", said(&a));
    }
}

#[test]
fn a_clip_is_one_and_may_be_a_spring_that_gives_way_where_nothing_but_a_spring_is_there() {
    let (a, _) = asked(&declared([1000.0, 50.0]), |x, _| {
        x.iter().map(|x| (1000.0 * x).clamp(-15e3, 15e3)).collect()
    });
    assert!(is_possible(&a, Effect::Saturation), "{}", said(&a));
    assert!(is_possible(&a, Effect::Softening), "{}", said(&a));
    // Damping beyond the limit is clipped, too: a spring that gives way would leave it.
    let (a, _) = asked(&declared([1000.0, 50.0]), |x, v| {
        let whole = plus(
            spring(x, v, 1000.0),
            &v.iter().map(|v| 4.0 * v).collect::<Vec<_>>(),
        );
        whole.iter().map(|f| f.clamp(-15e3, 15e3)).collect()
    });
    assert_eq!(names(&a), [Effect::Saturation], "{}", said(&a));
    assert!(!is_possible(&a, Effect::Softening), "{}", said(&a));
}

#[test]
fn what_yields_at_an_eighth_or_a_sixth_of_the_motion_may_be_friction_or_hysteresis() {
    for (yield_mm, force_n) in [(3.0, 1500.0), (3.6, 2200.0)] {
        for stiffness in [700.0, 1300.0] {
            let (a, _) = asked(&declared([stiffness, 50.0]), |x, v| {
                plus(spring(x, v, 700.0), &slider(x, yield_mm, force_n))
            });
            let both = [Effect::CoulombFriction, Effect::BilinearHysteresis];
            assert!(both.iter().all(|n| is_possible(&a, *n)), "{}", said(&a));
        }
    }
}

#[test]
fn a_late_force_is_late_by_what_it_is_and_no_dashpot_drives() {
    // Also between two samples, where the noise of the reading is late by the one or the other.
    for late_ms in [15.0, 14.49] {
        let (a, _) = asked(&declared([1000.0, 50.0]), |x, v| {
            let here = spring(x, v, 1000.0);
            let at = |t: f64| {
                let i = t.max(0.0) as usize;
                here[i] + (t.max(0.0) - i as f64) * (here[(i + 1).min(here.len() - 1)] - here[i])
            };
            (0..here.len()).map(|i| at(i as f64 - late_ms)).collect()
        });
        let skew = a.effects.iter().find(|e| e.name == Effect::ChannelSkew);
        let skew = skew.unwrap_or_else(|| panic!("{}", said(&a)));
        let [low, high] = skew.parameters[0].ci90;
        assert!(low < late_ms && high > late_ms, "{}", said(&a));
        // The damping beside it is known to 2 N s/mm, which on this spring are 2 ms: the motion tells little more.
        assert!(high - low > 0.5, "{}", said(&a));
        assert!(a.refitted[1].value >= 0.0, "{}", said(&a));
    }
}

#[test]
fn a_known_gain_on_a_clean_record_is_no_late_channel() {
    let mut model = declared([1000.0, 50.0]);
    let gain = plant::EffectSpec::new(Effect::GainError, &[("error", 0.05)]);
    model.specimen.as_mut().unwrap().effects.push(gain);
    let (a, _) = asked(&model, |x, v| spring(x, v, 1000.0));
    assert_eq!(a.verdict, Verdict::None, "{}", said(&a));
}

#[test]
fn a_dashpot_of_a_power_of_speed_is_saved_with_its_error() {
    for exponent in [0.35, 0.5] {
        let model = declared([1000.0, 50.0]);
        let force = |x: &[f64], v: &[f64]| {
            let dashpot = |v: &f64| 1500.0 * (v / 100.0).abs().powf(exponent).copysign(*v);
            plus(
                spring(x, v, 1000.0),
                &v.iter().map(dashpot).collect::<Vec<_>>(),
            )
        };
        let (first, found) = asked(&model, force);
        assert!(!first.effects.is_empty(), "{}", said(&first));
        let (again, _) = asked(&found.improved, force);
        let [reported, saved] = [first.error_after.test_rms, again.error_before.test_rms];
        assert!(
            saved < 1.1 * reported,
            "{exponent}: {reported} N is {saved} N as saved"
        );
    }
}

#[test]
fn a_line_in_the_rest_is_named_beside_what_has_no_name() {
    let shaken = |t: f64| 80.0 * (TAU * 24.7 * t).sin();
    let (a, _) = asked(&declared([1000.0, 50.0]), |x, v| {
        // Waves of the place and the speed: of no element.
        let odd =
            x.iter().zip(v).enumerate().map(|(i, (x, v))| {
                120.0 * (0.9 * x).sin() * (0.05 * v).cos() + shaken(i as f64 * H)
            });
        plus(spring(x, v, 1000.0), &odd.collect::<Vec<_>>())
    });
    let said_so = |n: &String| n.contains("disturbance of 24.7") && n.contains("amplitude of 79.");
    assert!(a.notes.iter().any(said_so), "{}", said(&a));
    let anatomy = a.remainder.as_ref().unwrap();
    assert!(anatomy.lines[0].at_rest, "{anatomy:?}");
}

#[test]
fn a_clock_of_another_rate_is_said() {
    let (a, _) = asked(&declared([1000.0, 50.0]), |x, v| {
        let here = spring(x, v, 1000.0);
        let n = here.len();
        let at = |t: f64| {
            let i = (t as usize).min(n - 2);
            here[i] + (t - i as f64) * (here[i + 1] - here[i])
        };
        (0..n).map(|i| at(i as f64 * (1.0 - 3e-4))).collect()
    });
    let clock = |n: &String| n.contains("speed times time") && n.contains("late");
    assert!(a.notes.iter().any(clock), "{}", said(&a));
}
