//! The decision, on one screen: three thresholds on a posterior, which nothing rewrites.

use super::posterior::{Candidate, Posterior};
use plant::Effect;

/// Structure below this share of the noise is nothing, where a rest tells the noise; twice that where none does.
pub const NOTHING: f64 = 0.42;
/// A name is given that is at least so probable.
pub const SURE: f64 = 0.72;
/// A set holds the cause with at least this probability.
pub const SET: f64 = 0.9;
/// A set of more names says nothing.
pub const LARGEST_SET: usize = 5;
/// Where a model leaves more than this share of the noise, a law that is not in the table may be the cause: of names that were given
/// for sure, all were right below it and four fifths above (a study on 200 records of two authors).
pub const UNEXPLAINED: f64 = 0.45;
/// The probability that such a law is the cause, below and above.
pub const NOT_IN_THE_TABLE: [f64; 2] = [0.02, 0.2];

/// What can be said of a channel.
#[derive(Clone, Debug)]
pub enum Said<M> {
    /// Nothing is missing.
    Nothing,
    /// These names are in it, each with its probability.
    Names(Candidate<M>, Vec<(Effect, f64)>),
    /// One of these is in it, beside those that are sure.
    Set(Candidate<M>, Vec<(Effect, f64)>),
    /// Something is, and no name can be given; the likeliest one's model.
    Unknown(Option<Candidate<M>>),
}

/// What a posterior allows to be said. `least` is what counts as nothing, over the noise.
pub fn verdict<M: Clone>(posterior: &Posterior<M>, least: f64) -> Said<M> {
    let left = |c: &Candidate<M>| c.evidence.left_rms();
    if posterior.declared().is_some_and(|c| left(c) < least) {
        return Said::Nothing;
    }
    let names = posterior.names();
    let sure: Vec<(Effect, f64)> = names.iter().copied().filter(|n| n.1 >= SURE).collect();
    let with = |all: &[Effect]| {
        let has = |c: &&Candidate<M>| all.iter().all(|n| c.names.contains(n));
        posterior.models.iter().map(|m| &m.0).find(has).cloned()
    };
    let only: Vec<Effect> = sure.iter().map(|n| n.0).collect();
    if !sure.is_empty() {
        // The model of exactly these names, where there is one; else the likeliest that has them.
        let exact = |c: &&Candidate<M>| {
            c.names.len() == only.len() && only.iter().all(|n| c.names.contains(n))
        };
        let model = posterior.models.iter().map(|m| &m.0).find(exact).cloned();
        if let Some(model) = model.or_else(|| with(&only)) {
            return Said::Names(model, sure);
        }
    }
    let named = posterior.models.iter().map(|m| &m.0);
    let likeliest = named.clone().find(|c| !c.names.is_empty()).cloned();
    // The smallest set of names one of which is in the rig with enough probability.
    let mut set: Vec<(Effect, f64)> = Vec::new();
    for name in names {
        set.push(name);
        let hit = |c: &Candidate<M>| set.iter().any(|n| c.names.contains(&n.0));
        let mass: f64 = posterior
            .models
            .iter()
            .filter(|m| hit(&m.0))
            .map(|m| m.1)
            .sum();
        if mass >= SET {
            break;
        }
        if set.len() == LARGEST_SET {
            return Said::Unknown(likeliest);
        }
    }
    let hit = |c: &Candidate<M>| set.iter().any(|n| c.names.contains(&n.0));
    let mass: f64 = posterior
        .models
        .iter()
        .filter(|m| hit(&m.0))
        .map(|m| m.1)
        .sum();
    match with(&[set.first().map_or(Effect::Offset, |n| n.0)]) {
        Some(model) if mass >= SET && set.len() > 1 => Said::Set(model, set),
        _ => Said::Unknown(likeliest),
    }
}
