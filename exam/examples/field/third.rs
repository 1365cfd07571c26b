//! What the model found leaves of a motion that was used neither for the fit nor for judging it.

use crate::grading::{model, recording, recordings};
use diagnosis::{Verdict, diagnose};
use exam::aims::{self, Figure};
use exam::field::{Believed, Stand, rms_apart, set_field};
use indicatif::ProgressBar;
use rayon::prelude::*;
use std::f64::consts::TAU;

/// Number of sines in a third motion.
const SINES: u32 = 12;
const SECONDS: f64 = 20.0;
/// The rig's simulation step, s.
const INTERVAL_S: f64 = 1.25e-4;

struct Third {
    id: String,
    verdict: Verdict,
    /// Rms of the error over the load cell's noise: of the third motion with the declared model and with the model found, and of
    /// the held-out record with the model found.
    over_noise: [f64; 3],
}

/// A sum of sines that swells and fades, within the rig's limits. None of them is in another record.
fn motion(stand: &Stand, seed: u64) -> Vec<f64> {
    let limits = stand.limits();
    let (x, v) = (limits.displacement_mm, limits.velocity_mm_per_s);
    // At this frequency a sine over the whole range reaches the top speed.
    let top_hz = v / (TAU * x);
    let sines: Vec<[f64; 3]> = (1..=SINES)
        .map(|k| {
            let share = f64::from(k) / f64::from(SINES);
            let phase = (seed.wrapping_mul(u64::from(k * k)) % 997) as f64 / 997.0;
            [top_hz * (0.1 + 0.83 * share), 1.0 / (0.3 + share), phase]
        })
        .collect();
    let n = (SECONDS / INTERVAL_S) as usize;
    let at = |i: usize| {
        let t = i as f64 * INTERVAL_S;
        let swell = (t.min(SECONDS - t) / 2.0).clamp(0.0, 1.0);
        let sum: f64 = sines
            .iter()
            .map(|[hz, a, phase]| a * (TAU * (hz * t + phase)).sin())
            .sum();
        // Without corners, which would show through a mass.
        swell * swell * (3.0 - 2.0 * swell) * sum
    };
    let way: Vec<f64> = (0..n).map(at).collect();
    let step = |w: &[f64]| (w[1] - w[0]).abs() / INTERVAL_S;
    let far = way.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let fast = way.windows(2).map(step).fold(0.0_f64, f64::max);
    let by = 0.8 * (x / far).min(v / fast);
    way.into_iter().map(|x| by * x).collect()
}

fn ask(seed: u64) -> Option<Third> {
    let field = set_field(seed);
    let stand = field.stand.as_ref()?;
    if !matches!(field.believed, Believed::Specimen(_)) || field.noise_rms <= 0.0 {
        return None;
    }
    let declared = model(&field.believed);
    let [train, test] = recordings(&field).map(|r| [r]);
    let found = diagnose(&declared, &train, &test, &[]).ok()?;
    let [third, truth] = stand.play_with_truth(&motion(stand, seed), INTERVAL_S, seed ^ 0x3D);
    let noise_n = rms_apart(&third.force_n, &truth.force_n);
    let third = [recording("third", &third, None)];
    let left = |model| {
        let of = diagnose(model, &train, &third, &[]).ok()?;
        Some(of.channels[0].error_declared.test_rms)
    };
    let held_out = found.channels[0].error_after.test_rms;
    let over_noise = [left(&declared)?, left(&found.improved)?, held_out].map(|e| e / noise_n);
    Some(Third {
        id: field.id,
        verdict: found.channels[0].verdict,
        over_noise,
    })
}

/// Has each noisy specimen among `seeds` play a third motion.
pub fn all(seeds: Vec<u64>, list: bool) {
    let bar = ProgressBar::new(seeds.len() as u64);
    let seeds = seeds.into_par_iter().inspect(|_| bar.inc(1));
    let all: Vec<Third> = seeds.filter_map(ask).collect();
    if list {
        for t in &all {
            println!("{:?} [{}] {:.2?}", t.verdict, t.id, t.over_noise);
        }
    }
    println!(
        "| answer | rigs | as declared | as found | as found, held out |\n|---|---|---|---|---|"
    );
    let mean = |of: &[&Third], which: usize| {
        let logs: f64 = of.iter().map(|t| t.over_noise[which].ln()).sum();
        (logs / of.len() as f64).exp()
    };
    let row = |name: &str, of: &[&Third]| {
        if !of.is_empty() {
            let [declared, found, held_out] = [0, 1, 2].map(|which| mean(of, which));
            println!(
                "| {name} | {} | {declared:.1} | {found:.2} | {held_out:.2} |",
                of.len()
            );
        }
    };
    for verdict in [
        Verdict::Effect,
        Verdict::Partial,
        Verdict::Ambiguous,
        Verdict::Unknown,
        Verdict::None,
    ] {
        let of: Vec<&Third> = all.iter().filter(|t| t.verdict == verdict).collect();
        row(&format!("`{verdict:?}`").to_lowercase(), &of);
    }
    let every: Vec<&Third> = all.iter().collect();
    row("**all**", &every);
    let value = (!every.is_empty()).then(|| mean(&every, 1));
    let figure = Figure {
        value,
        of: every.len(),
    };
    println!(
        "\nrms over the load cell's noise, geometric means\n\n{}",
        aims::table(&[(&aims::THIRD_MOTION, &[figure])])
    );
}
