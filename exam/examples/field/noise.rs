//! The stated noise of records without a rest, compared with the true noise.

use crate::grading::{model, recordings};
use exam::field::{Believed, Field, causes};
use indicatif::ProgressBar;
use rayon::prelude::*;

/// A stated noise may be wrong by this factor.
const WITHIN: f64 = 1.3;

struct Stated {
    id: String,
    cause: &'static str,
    actuator: bool,
    verdict: String,
    /// Stated noise over the true one; if the record has no noise, over the output's rms.
    ratio: f64,
    /// True noise over the output's rms.
    truth: f64,
}

impl Stated {
    fn is_near(&self) -> bool {
        (1.0 / WITHIN..=WITHIN).contains(&self.ratio)
    }
}

fn rms(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt()
}

fn ask(field: Field) -> Stated {
    let [train, test] = recordings(&field);
    let actuator = matches!(field.believed, Believed::Actuator(_));
    let output = if actuator {
        &train.displacement_mm
    } else {
        &train.force_n
    };
    let whole = rms(output.as_deref().unwrap_or_default());
    let found = diagnosis::diagnose(&model(&field.believed), &[train], &[test], &[]);
    let (stated, verdict) = match found {
        Ok(d) => (
            d.channels[0].noise_floor_rms,
            format!("{:?}", d.channels[0].verdict),
        ),
        Err(why) => (f64::NAN, format!("refused: {why}")),
    };
    let truth = field.noise_rms / whole;
    Stated {
        ratio: stated / if truth > 0.0 { field.noise_rms } else { whole },
        truth,
        cause: field.truth.cause,
        id: field.id,
        actuator,
        verdict,
    }
}

/// Diagnoses the records among `seeds` that have no rest.
pub fn all(seeds: Vec<u64>, set: fn(u64) -> Field, list: bool) {
    let bar = ProgressBar::new(seeds.len() as u64);
    let fields = seeds.into_par_iter().inspect(|_| bar.inc(1));
    let all: Vec<Stated> = fields
        .map(set)
        .filter(|f| !f.rests)
        .map(ask)
        .inspect(|s| {
            if list && !s.is_near() {
                let Stated { ratio, truth, .. } = s;
                println!("{ratio:.3} at {truth:.1e} [{}] {}", s.id, s.verdict);
            }
        })
        .collect();
    let (noisy, exact): (Vec<&Stated>, Vec<&Stated>) = all.iter().partition(|s| s.truth > 0.0);
    println!(
        "| records without a rest | of | within {WITHIN} | 5 % | median | 95 % | not stated |"
    );
    println!("|---|---|---|---|---|---|---|");
    let row = |name: &str, of: Vec<&&Stated>| {
        let mut ratios: Vec<f64> = of
            .iter()
            .map(|s| s.ratio)
            .filter(|r| r.is_finite())
            .collect();
        if of.is_empty() {
            return;
        }
        ratios.sort_by(f64::total_cmp);
        let none = of.len() - ratios.len();
        let at = |share: f64| {
            let place = (share * ratios.len() as f64) as usize;
            ratios
                .get(place.min(ratios.len().saturating_sub(1)))
                .copied()
        };
        let [low, middle, high] = [0.05, 0.5, 0.95].map(|s| at(s).unwrap_or(f64::NAN));
        let near = of.iter().filter(|s| s.is_near()).count();
        println!(
            "| {name} | {} | {near} ({:.1} %) | {low:.2} | {middle:.2} | {high:.2} | {none} |",
            of.len(),
            100.0 * near as f64 / of.len() as f64
        );
    };
    for cause in causes() {
        row(cause, noisy.iter().filter(|s| s.cause == cause).collect());
    }
    row(
        "**specimens**",
        noisy.iter().filter(|s| !s.actuator).collect(),
    );
    row(
        "**actuators**",
        noisy.iter().filter(|s| s.actuator).collect(),
    );
    row("**all**", noisy.iter().collect());
    if exact.is_empty() {
        return;
    }
    let mut stated: Vec<f64> = exact
        .iter()
        .map(|s| s.ratio)
        .filter(|r| r.is_finite())
        .collect();
    stated.sort_by(f64::total_cmp);
    println!(
        "\n{} records beside these have no noise at all: stated is, over the rms of the output, {:.1e} in the middle and {:.1e} at most",
        exact.len(),
        stated.get(stated.len() / 2).unwrap_or(&f64::NAN),
        stated.last().unwrap_or(&f64::NAN)
    );
}
