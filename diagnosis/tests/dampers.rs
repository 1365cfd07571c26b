//! Fluid dampers, whose force grows with a power of the speed below 1, declared by the linear dashpot of the same energy.
#![allow(missing_docs)]

mod spring;

use diagnosis::{ChannelAnswer, Declared, Verdict, diagnose};
use plant::Effect;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use spring::{declared, in_two};
use std::f64::consts::TAU;

const H: f64 = 2e-3;
/// Of the damper's equation for each sample.
const SUBSTEPS: usize = 20;
/// `at_1_mm_per_s_n |v|^exponent`, behind a spring if there is one, N/mm.
#[derive(Clone, Copy)]
struct Damper {
    at_1_mm_per_s_n: f64,
    exponent: f64,
    spring_n_per_mm: Option<f64>,
}

/// Ten sines of 0.2 to 2 Hz, mm.
fn place(t: f64) -> f64 {
    let sine = |k: usize| {
        let hz = 0.2 * k as f64 + 0.007 * (k * k % 5) as f64;
        (TAU * hz * t + 1.7 * (k * k) as f64).sin() / k as f64
    };
    30.0 * (t / 2.0).min(1.0) * (1..=10).map(sine).sum::<f64>()
}

fn forces(damper: Damper, n: usize) -> Vec<f64> {
    let h = H / SUBSTEPS as f64;
    let c = damper.at_1_mm_per_s_n;
    let mut piston = place(0.0);
    let mut force = vec![0.0];
    for i in 1..n * SUBSTEPS {
        let t = h * i as f64;
        let now = if let Some(k) = damper.spring_n_per_mm {
            let f = k * (place(t) - piston);
            piston += h * (f.abs() / c).powf(1.0 / damper.exponent).copysign(f);
            f
        } else {
            let v = (place(t + h) - place(t - h)) / (2.0 * h);
            c * v.abs().powf(damper.exponent).copysign(v)
        };
        if i % SUBSTEPS == 0 {
            force.push(now);
        }
    }
    force
}

const fn value(value: f64, tolerance: f64) -> Option<Declared> {
    Some(Declared { value, tolerance })
}

/// Declared by a dashpot, N s/mm and its tolerance.
fn asked(damper: Damper, dashpot: Option<Declared>) -> ChannelAnswer {
    let n = 24_000;
    let force = forces(damper, n);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut noise = |rms: f64| rms * Distribution::<f64>::sample(&StandardNormal, &mut random);
    let force: Vec<f64> = force.iter().map(|f| f + noise(300.0)).collect();
    let x: Vec<f64> = (0..n).map(|i| place(H * i as f64) + noise(0.03)).collect();
    let [train, test] = in_two(&x, &force, H);
    let mut model = declared();
    let specimen = model.specimen.as_mut().unwrap();
    specimen.stiffness_n_per_mm = value(0.0, 10.0);
    specimen.damping_n_s_per_mm = dashpot;
    specimen.mass_kg = None;
    specimen.offset_n = value(0.0, 200.0);
    let found = diagnose(&model, &[train], &[test], &[]).unwrap();
    found.channels.into_iter().next().unwrap()
}

fn assert_found(answer: &ChannelAnswer, name: Effect, wanted: &[(&str, f64, f64)]) {
    assert!(
        matches!(answer.verdict, Verdict::Effect | Verdict::Partial),
        "{:?} {:?}",
        answer.verdict,
        answer.effects
    );
    let names: Vec<Effect> = answer.effects.iter().map(|e| e.name).collect();
    assert_eq!(names, [name]);
    for &(key, value, within) in wanted {
        let parameters = &answer.effects[0].parameters;
        let own = parameters.iter().find(|p| p.name == key).unwrap();
        assert!((own.value - value).abs() < within, "{key} {}", own.value);
    }
}

#[test]
fn a_fluid_damper_takes_the_place_of_the_dashpot_that_is_declared() {
    let damper = Damper {
        at_1_mm_per_s_n: 3000.0,
        exponent: 0.7,
        spring_n_per_mm: None,
    };
    // Of it three tolerances are 150 N s/mm, and nothing is there.
    let answer = asked(damper, value(600.0, 50.0));
    assert_found(&answer, Effect::ViscousDamping, &[("exponent", 0.7, 0.02)]);
}

#[test]
fn a_fluid_damper_behind_its_brace_is_no_hysteresis() {
    let damper = Damper {
        at_1_mm_per_s_n: 10_000.0,
        exponent: 0.5,
        spring_n_per_mm: Some(8000.0),
    };
    let answer = asked(damper, value(800.0, 100.0));
    let brace = ("stiffness_n_per_mm", 8000.0, 400.0);
    assert_found(
        &answer,
        Effect::MaxwellDamper,
        &[brace, ("exponent", 0.5, 0.03)],
    );
}

/// Nor friction: by the exponent, however stiff the brace is.
#[test]
fn a_fluid_damper_of_a_small_exponent_behind_a_stiff_brace_is_no_friction() {
    let damper = Damper {
        at_1_mm_per_s_n: 10_000.0,
        exponent: 0.38,
        spring_n_per_mm: Some(20_000.0),
    };
    let answer = asked(damper, value(0.0, 10.0));
    let names: Vec<Effect> = answer.effects.iter().map(|e| e.name).collect();
    assert_eq!(names[..1], [Effect::MaxwellDamper], "{answer:?}");
    assert!(
        !answer.alternatives.contains(&Effect::CoulombFriction),
        "{:?}",
        answer.alternatives
    );
    let parameters = &answer.effects[0].parameters;
    let exponent = parameters.iter().find(|p| p.name == "exponent").unwrap();
    assert!((exponent.value - 0.38).abs() < 0.03, "{exponent:?}");
}
