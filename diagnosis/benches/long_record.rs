//! Seconds that a record of 60 000 samples takes, both channels of it, by how many causes it has.
//!
//! `cargo bench -p diagnosis --bench long_record`
#![allow(missing_docs)]

#[allow(dead_code, reason = "tests use more of it")]
#[path = "../tests/rig/mod.rs"]
mod rig;

use diagnosis::diagnose;
use plant::{Effect, EffectSpec};
use std::time::Instant;

/// At 1000 Hz.
const SECONDS: f64 = 60.0;
const TRUTH: [f64; 3] = [1004.0, 5.2, 22.4];
/// What was aimed at, s.
const AIM_S: f64 = 3.0;
const RUNS: usize = 3;

fn main() {
    let causes = [
        EffectSpec::new(
            Effect::CoulombFriction,
            &[("force_n", 150.0), ("presliding_mm", 0.05)],
        ),
        EffectSpec::new(
            Effect::Hardening,
            &[("reference_mm", 30.0), ("exponent", 2.0)],
        ),
        EffectSpec::new(Effect::Backlash, &[("width_mm", 0.4)]),
    ];
    println!("| causes | found | seconds | aim |\n|---|---|---|---|");
    for count in 0..=causes.len() {
        let own = &causes[..count];
        let [train, test] = [1, 2].map(|seed| [rig::record_over(SECONDS, own, TRUTH, seed)]);
        let mut best_s = f64::INFINITY;
        let mut names = Vec::new();
        for _ in 0..RUNS {
            let began = Instant::now();
            let found = diagnose(&rig::model(), &train, &test, &[]).expect("an answer");
            best_s = best_s.min(began.elapsed().as_secs_f64());
            let effects = found.channels.iter().flat_map(|c| &c.effects);
            names = effects.map(|e| e.name.name()).collect();
        }
        let missed = match best_s - AIM_S {
            by if by > 0.0 => format!("missed by {by:.1} s"),
            _ => "met".into(),
        };
        println!(
            "| {count} | {} | {best_s:.1} | {missed} |",
            names.join(", ")
        );
    }
}
