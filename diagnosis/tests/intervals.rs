//! Intervals of what is named hold the truth: textbook rigs without a rest, of several effects and noises.
#![allow(missing_docs)]
#![cfg(not(debug_assertions))] // Minutes without optimisation.

mod spring;

use diagnosis::{FoundEffect, Recording, diagnose};
use plant::Effect;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use spring::{DAMPING_N_S_PER_MM, STIFFNESS_N_PER_MM, declared, in_two};
use std::f64::consts::TAU;

const H: f64 = 4e-3;
const SECONDS: f64 = 40.0;
/// Motion and force between two samples of the record.
const FINE: usize = 8;

/// A true number of an effect, by the name of the parameter.
type Truth = fn(&str, &FoundEffect) -> Option<f64>;
/// A force over a motion and its speed, one sample every `H / FINE`.
type Force = fn(&[f64], &[f64]) -> Vec<f64>;

/// Bristles (Dahl), exact over each sample.
fn friction(x: &[f64], force_n: f64, give_mm: f64) -> Vec<f64> {
    let (mut z, mut last) = (0.0, x[0]);
    let step = |x: &f64| {
        let way = x - last;
        last = *x;
        let end = way.signum();
        z = end + (z - end) * (-way.abs() / give_mm).exp();
        force_n * z
    };
    x.iter().map(step).collect()
}

/// Elastic, then it slides.
fn slider(x: &[f64], stiffness_n_per_mm: f64, yield_mm: f64) -> Vec<f64> {
    let (mut z, mut last) = (0.0_f64, x[0]);
    let step = |x: &f64| {
        z = (z + x - last).clamp(-yield_mm, yield_mm);
        last = *x;
        stiffness_n_per_mm * z
    };
    x.iter().map(step).collect()
}

/// A spring behind a dashpot.
fn relaxing(v: &[f64], stiffness_n_per_mm: f64, seconds: f64) -> Vec<f64> {
    let h = H / FINE as f64;
    let mut f = 0.0;
    let step = |v: &f64| {
        f += h * (stiffness_n_per_mm * v - f / seconds);
        f
    };
    v.iter().map(step).collect()
}

fn value(e: &FoundEffect, name: &str) -> f64 {
    let mut all = e.parameters.iter();
    all.find(|p| p.name == name).map_or(f64::NAN, |p| p.value)
}

/// Each with its name, its force, and its numbers.
const RIGS: [(Effect, Force, Truth); 7] = [
    (
        Effect::CoulombFriction,
        |x, _| friction(x, 300.0, 0.01),
        |name, _| (name == "force_n").then_some(300.0),
    ),
    (
        Effect::CoulombFriction,
        |x, v| {
            let both = friction(x, 300.0, 0.01).into_iter().zip(v);
            both.map(|(f, v)| f + 6.0 * v).collect()
        },
        |name, _| (name == "force_n").then_some(300.0),
    ),
    (
        Effect::CoulombFriction,
        |x, _| slider(x, 1e4, 0.04),
        |name, _| match name {
            "force_n" => Some(400.0),
            _ => None,
        },
    ),
    (
        Effect::QuadraticDamping,
        |_, v| v.iter().map(|v| 0.1 * v * v.abs()).collect(),
        |name, e| match name {
            "force_at_top_speed_n" => Some(0.1 * value(e, "top_speed_mm_per_s").powi(2)),
            "exponent" => Some(2.0),
            _ => None,
        },
    ),
    (
        Effect::BilinearHysteresis,
        |x, _| slider(x, 400.0, 2.0),
        |name, _| match name {
            "stiffness_n_per_mm" => Some(400.0),
            "yield_mm" => Some(2.0),
            _ => None,
        },
    ),
    (
        Effect::Hardening,
        |x, _| x.iter().map(|x| 2.0 * x.powi(3)).collect(),
        |name, e| match name {
            "stiffness_added_n_per_mm" => Some(2.0 * value(e, "at_mm").powi(2)),
            "reference_mm" => Some((STIFFNESS_N_PER_MM / 2.0).sqrt()),
            "exponent" => Some(2.0),
            _ => None,
        },
    ),
    (
        Effect::MaxwellDamper,
        |_, v| relaxing(v, 400.0, 0.1),
        |name, _| match name {
            "stiffness_n_per_mm" => Some(400.0),
            "relaxation_ms" => Some(100.0),
            _ => None,
        },
    ),
];

/// A record of a force beside a spring and a dashpot, in mid-motion at both ends: what is learnt from, and what is judged on.
fn recorded(force: Force, noise: [f64; 2], seed: u64) -> [Recording; 2] {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut unit = || -> f64 { StandardNormal.sample(&mut random) };
    let sines: Vec<(f64, f64)> = (1..=12)
        .map(|k| (0.25 * f64::from(k) + 0.02 * unit(), TAU * unit()))
        .collect();
    let n = (SECONDS / H) as usize * FINE;
    let h = H / FINE as f64;
    let over = |of: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let at = |i: usize| {
            let all = sines
                .iter()
                .map(|&(hz, p)| of(hz, TAU * hz * i as f64 * h + p));
            3.0 * all.sum::<f64>()
        };
        (0..n).map(at).collect()
    };
    let x = over(&|hz, p| p.sin() / hz.sqrt());
    let v = over(&|hz, p| TAU * hz.sqrt() * p.cos());
    let more = force(&x, &v);
    let at = (0..n).step_by(FINE);
    let f: Vec<f64> = at
        .clone()
        .map(|i| {
            STIFFNESS_N_PER_MM * x[i] + DAMPING_N_S_PER_MM * v[i] + more[i] + noise[1] * unit()
        })
        .collect();
    let x: Vec<f64> = at.map(|i| x[i] + noise[0] * unit()).collect();
    in_two(&x, &f, H)
}

#[test]
fn ninety_percent_intervals_hold_the_truth_of_textbook_rigs() {
    let (mut held, mut all) = (0_u32, 0_u32);
    for (rig, (effect, force, truth)) in RIGS.into_iter().enumerate() {
        for (noise, seed) in [([0.002, 5.0], 1), ([0.01, 20.0], 2), ([0.005, 60.0], 3)] {
            let [train, test] = recorded(force, noise, 10 * rig as u64 + seed);
            let found = diagnose(&declared(), &[train], &[test], &[]).expect("an answer");
            let answer = &found.channels[0];
            let named = answer.effects.iter().find(|e| e.name == effect);
            let names: Vec<Effect> = answer.effects.iter().map(|e| e.name).collect();
            println!("{effect} {noise:?}: {:?} {names:?}", answer.verdict);
            for p in named.iter().flat_map(|e| &e.parameters) {
                let Some(truth) = named.and_then(|e| truth(&p.name, e)) else {
                    continue;
                };
                let [low, high] = p.ci90;
                let holds = (low..=high).contains(&truth);
                let mark = if holds { ' ' } else { '!' };
                println!(
                    "  {mark} {} {:.4} ({low:.4} to {high:.4}), truth {truth:.4}",
                    p.name, p.value
                );
                (held, all) = (held + u32::from(holds), all + 1);
                assert!(
                    (p.value / truth - 1.0).abs() < 0.03,
                    "{} {}",
                    p.name,
                    p.value
                );
            }
        }
    }
    println!("{held} of {all}");
    assert!(all >= 25, "{all} judged");
    assert!(f64::from(held) >= 0.85 * f64::from(all), "{held} of {all}");
}
