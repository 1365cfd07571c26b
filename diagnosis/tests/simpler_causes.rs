//! Textbook causes that a more flexible name fits as well: it is not given alone.
#![allow(missing_docs)]

use diagnosis::{ChannelAnswer, Declared, Model, Recording, SpecimenModel, diagnose};
use plant::Effect;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::TAU;

const H: f64 = 2e-3;
const STIFFNESS_N_PER_MM: f64 = 1000.0;
const DAMPING_N_S_PER_MM: f64 = 0.5;

/// Twelve sines of up to 3 Hz under an envelope of time over length.
fn shaken(seconds: f64, envelope: impl Fn(f64) -> f64) -> Vec<f64> {
    let at = |i: usize| {
        let t = i as f64 * H;
        let sines = (1..=12).map(|k| {
            let hz = 0.25 * f64::from(k) + 0.011 * f64::from(k * k % 7);
            (TAU * hz * t + 2.1 * f64::from(k * k)).sin() / f64::from(k).sqrt()
        });
        6.0 * envelope(t / seconds) * sines.sum::<f64>()
    };
    (0..(seconds / H) as usize).map(at).collect()
}

/// Speed, mm/s.
fn speed(x: &[f64], i: usize) -> f64 {
    (x[(i + 1).min(x.len() - 1)] - x[i.saturating_sub(1)]) / (2.0 * H)
}

/// Bristles of 30 kN/mm (Dahl), exact over each sample.
fn friction(x: &[f64], force_n: f64) -> Vec<f64> {
    let stiff = 3e4;
    let mut f = 0.0;
    let step = |i: usize| {
        let dx = if i == 0 { 0.0 } else { x[i] - x[i - 1] };
        let end = force_n * dx.signum();
        f = end + (f - end) * (-stiff * dx.abs() / force_n).exp();
        f
    };
    (0..x.len()).map(step).collect()
}

/// Learned from the first three fifths of a record and judged on the rest.
fn asked(x: &[f64], more_n: &[f64]) -> ChannelAnswer {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut noise = |rms: f64| rms * Distribution::<f64>::sample(&StandardNormal, &mut random);
    let force: Vec<f64> = (0..x.len())
        .map(|i| {
            STIFFNESS_N_PER_MM * x[i] + DAMPING_N_S_PER_MM * speed(x, i) + more_n[i] + noise(10.0)
        })
        .collect();
    let read: Vec<f64> = x.iter().map(|x| x + noise(0.01)).collect();
    let split = 3 * x.len() / 5;
    let part = |name: &str, from: usize, end: usize| Recording {
        name: name.into(),
        time_s: (from..end).map(|i| i as f64 * H).collect(),
        displacement_mm: Some(read[from..end].to_vec()),
        force_n: Some(force[from..end].to_vec()),
        ..Recording::default()
    };
    let train = part("train", 0, split);
    let mut test = part("test", split, x.len());
    test.before = Some(Box::new(train.clone()));
    let declared = |value, tolerance| Some(Declared { value, tolerance });
    let model = Model {
        specimen: Some(SpecimenModel {
            stiffness_n_per_mm: declared(STIFFNESS_N_PER_MM, 20.0),
            damping_n_s_per_mm: declared(DAMPING_N_S_PER_MM, 0.2),
            mass_kg: declared(0.0, 0.5),
            offset_n: declared(0.0, 20.0),
            ..SpecimenModel::default()
        }),
        ..Model::default()
    };
    let found = diagnose(&model, &[train], &[test], &[]).expect("an answer");
    found.channels.into_iter().next().expect("the specimen")
}

fn is_held_possible(a: &ChannelAnswer, name: Effect) -> bool {
    a.effects.iter().any(|e| e.name == name) || a.members.iter().any(|m| m.name == name)
}

/// Rests of a part of a second at both ends.
fn between_rests(u: f64, rest: f64) -> f64 {
    let into = ((u - rest).min(1.0 - rest - u) / rest).clamp(0.0, 1.0);
    0.5 - 0.5 * (0.5 * TAU * into).cos()
}

#[test]
fn friction_of_a_short_record_is_not_said_to_fall_with_speed() {
    let x = shaken(9.0, |u| between_rests(u, 0.05));
    let a = asked(&x, &friction(&x, 300.0));
    assert!(is_held_possible(&a, Effect::CoulombFriction), "{a:?}");
}

#[test]
fn damage_of_growing_cycles_is_no_change_with_time() {
    let seconds = 60.0;
    let cycles = |i: usize| {
        let t = i as f64 * H;
        let grown = ((0.5 * t).floor() + 1.0) / (0.5 * seconds);
        20.0 * grown * between_rests(t / seconds, 0.03) * (TAU * 0.5 * t).sin()
    };
    let x: Vec<f64> = (0..(seconds / H) as usize).map(cycles).collect();
    let mut largest = 0.0_f64;
    let lost: Vec<f64> = x
        .iter()
        .map(|x| {
            largest = largest.max(x.abs());
            -0.3 * STIFFNESS_N_PER_MM * x * largest / 25.0
        })
        .collect();
    let a = asked(&x, &lost);
    let names: Vec<Effect> = a.effects.iter().map(|e| e.name).collect();
    assert_eq!(
        names,
        [Effect::Degradation],
        "{:?} {:?} {:?} {:?}",
        a.verdict,
        a.members,
        a.nearest,
        a.tried
    );
}
