//! What is still possible after a diagnosis, each as a whole model.

use crate::answer::{ChannelAnswer, FoundEffect, Verdict};
use crate::base::Base;
use crate::engine;
use crate::fit::{Frame, settle};
use crate::improved::improve;
use crate::library::candidates;
use crate::model::Model;
use crate::noise::Noise;
use crate::problem::Problem;
use crate::recording::Recording;
use crate::signals::rms;
use crate::spectrum;
use plant::{Channel, Effect, Family};
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;

/// A model that is still possible.
#[derive(Clone, Debug)]
pub struct Cause {
    /// What it has that the declared model lacks; none: nothing.
    pub name: Option<Effect>,
    /// How probable it is, where the diagnosis says so.
    pub probability: Option<f64>,
    /// The whole model.
    pub model: Model,
}

/// Where nothing can be vouched for, so many of the nearest names are told apart.
const NEAREST: usize = 4;
/// What leaves more than this many times the rms of the best is none of the nearest.
const FAR: f64 = 1.5;
/// Samples that a fit makes do with.
const SAMPLES: usize = 8000;

/// What is left of the training data by a model with one name more.
type FittedModel = (Effect, Model, f64);

/// The models between which the answer of a channel leaves the choice, the preferred one first; one alone where it leaves
/// none.
pub fn causes(
    declared: &Model,
    improved: &Model,
    answer: &ChannelAnswer,
    train: &[Recording],
) -> Vec<Cause> {
    let preferred = Cause {
        name: answer.effects.first().map(|e| e.name),
        probability: answer.members.first().map(|m| m.probability),
        model: improved.clone(),
    };
    match answer.verdict {
        Verdict::Ambiguous => {
            let probability = |name| {
                let own = answer.members.iter().find(|m| m.name == name);
                own.map(|m| m.probability)
            };
            let wanted = |name| answer.alternatives.contains(&name);
            let rivals = fitted(declared, answer.channel, train, wanted);
            let rivals = rivals.into_iter().map(|(name, model, _)| Cause {
                name: Some(name),
                probability: probability(name),
                model,
            });
            std::iter::once(preferred).chain(rivals).collect()
        }
        Verdict::Partial | Verdict::Unknown => {
            // What is missing still, or at all: the nearest of each family.
            let known: Vec<Effect> = answer.effects.iter().map(|e| e.name).collect();
            // A line in the mains' band is no matter of the motion.
            let wanted = |name: Effect| {
                !known.contains(&name) && name.entry().family != Family::Interference
            };
            let all = fitted(improved, answer.channel, train, wanted);
            let most = all.first().map_or(0.0, |f| FAR * f.2);
            let mut families: Vec<Family> = Vec::new();
            let mut nearest: Vec<Cause> = Vec::new();
            for (name, model, left) in all {
                let family = name.entry().family;
                if left <= most && !families.contains(&family) && nearest.len() < NEAREST {
                    families.push(family);
                    nearest.push(Cause {
                        name: Some(name),
                        probability: None,
                        model,
                    });
                }
            }
            if nearest.is_empty() {
                vec![preferred]
            } else {
                nearest
            }
        }
        Verdict::None | Verdict::Effect | Verdict::NotAssessed => vec![preferred],
    }
}

/// One model for each wanted name, best first; each name with the form that leaves least.
fn fitted(
    model: &Model,
    channel: Channel,
    train: &[Recording],
    wanted: impl Fn(Effect) -> bool + Sync,
) -> Vec<FittedModel> {
    let all = match channel {
        Channel::Specimen => engine::one_each(model, train, wanted),
        Channel::Actuator => catalogued(model, channel, train, &wanted),
    };
    let mut all = all.unwrap_or_default();
    all.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut names: Vec<Effect> = Vec::new();
    all.retain(|f| {
        let new = !names.contains(&f.0);
        names.push(f.0);
        new
    });
    all
}

/// The effects of the catalogue, one at a time beside the declared parameters.
fn catalogued(
    model: &Model,
    channel: Channel,
    train: &[Recording],
    wanted: impl Fn(Effect) -> bool + Sync,
) -> Option<Vec<FittedModel>> {
    let base = Base::of(model, channel)?;
    let h = train.first()?.interval_s();
    let band = train
        .iter()
        .filter_map(|r| spectrum::motion_band_hz(r.displacement_mm.as_ref()?, h))
        .fold(0.0, f64::max);
    let cutoff_hz = if band > 0.0 { 3.0 * band } else { 0.1 / h };
    let problem = Problem::new(&base, train, cutoff_hz.min(0.3 / h), &[])?;
    let own = rms(&problem.residuals(&[], &problem.scales));
    let noise = white(own.max(f64::MIN_POSITIVE), h);
    let samples: usize = train.iter().map(|r| r.time_s.len()).sum();
    let every = samples.div_ceil(SAMPLES).max(noise.every);
    let thin = problem.thinned(every);
    let thin_noise = noise.thinned(every.div_ceil(noise.every));
    let frame = Frame::new(&thin, &base, &thin_noise, &[]);
    let fits = candidates(channel);
    let fits = fits.par_iter().filter(|c| wanted(c.effect));
    let fits = fits.filter_map(|candidate| {
        let (shapes, _) = frame.search(candidate)?;
        let solution = settle(&problem, &base, &noise, &[(*candidate, shapes)])?;
        let scales = &solution.problem.scales;
        let left = rms(&solution.problem.residuals(&solution.effects, scales));
        let found = solution.effects.iter().map(|e| {
            let parameters = (e.candidate.parameters)(&e.amplitudes, &e.shapes, scales);
            let exact = parameters
                .into_iter()
                .map(|(name, unit, value)| (name, unit, value, [value; 2]));
            FoundEffect::new(e.candidate.effect, exact)
        });
        let found: Vec<FoundEffect> = found.collect();
        let mut with = model.clone();
        improve(&base, &solution, &found, &mut with);
        with.check().ok()?;
        left.is_finite().then_some((candidate.effect, with, left))
    });
    Some(fits.collect())
}

/// White noise: what a fit without a rest weighs samples by.
fn white(rms: f64, interval_s: f64) -> Noise {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    let even = |x: u64| rms * 12.0_f64.sqrt() * ((x >> 11) as f64 / (1u64 << 53) as f64 - 0.5);
    let sample: Vec<f64> = (0..20_000).map(|_| even(rng.next_u64())).collect();
    Noise::at_rest(&[sample], interval_s, 1e-3 * rms)
}
