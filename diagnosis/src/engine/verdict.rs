//! The decision, on one screen: three thresholds on a posterior, which nothing rewrites.

use super::posterior::{Candidate, Posterior};
use plant::Effect;

/// Structure below the first share of the noise is nothing. Where no rest tells the noise, below the second, too, unless a model
/// speaks against it.
pub const NOTHING: [f64; 2] = [0.42, 0.84];
/// By so much, nats: half of the squares.
pub const SPEAKS: f64 = 5.5;
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

/// What a posterior allows to be said. What counts as nothing, over the noise: in any case, and where no model speaks against it.
pub fn verdict<M: Clone>(posterior: &Posterior<M>, [sure, most]: [f64; 2]) -> Said<M> {
    let best = posterior.models.first().map(|m| m.0.evidence.score());
    let is_nothing = |c: &Candidate<M>| {
        let left = c.evidence.left_rms();
        let silent = best.is_none_or(|best| best - c.evidence.score() < SPEAKS);
        left < sure || left < most && silent
    };
    if posterior.declared().is_some_and(is_nothing) {
        return Said::Nothing;
    }
    let names = posterior.names();
    let sure: Vec<(Effect, f64)> = names.iter().copied().filter(|n| n.1 >= SURE).collect();
    let with = |all: &[Effect]| {
        let has = |c: &&Candidate<M>| !c.nameless && all.iter().all(|n| c.names.contains(n));
        posterior.models.iter().map(|m| &m.0).find(has).cloned()
    };
    let only: Vec<Effect> = sure.iter().map(|n| n.0).collect();
    if !sure.is_empty() {
        // The model of exactly these names, where there is one; else the likeliest that has them.
        let exact = |c: &&Candidate<M>| {
            let all = only.iter().all(|n| c.names.contains(n));
            !c.nameless && c.names.len() == only.len() && all
        };
        let model = posterior.models.iter().map(|m| &m.0).find(exact).cloned();
        if let Some(model) = model.or_else(|| with(&only)) {
            return Said::Names(model, sure);
        }
    }
    let named = posterior.models.iter().map(|m| &m.0);
    let likeliest = named.clone().find(|c| !c.names.is_empty() && !c.nameless);
    // The smallest set of names one of which is in the rig with enough probability.
    let holds = |set: &[(Effect, f64)]| {
        let hit = |c: &Candidate<M>| set.iter().any(|n| c.names.contains(&n.0));
        let all = posterior.models.iter().filter(|m| hit(&m.0));
        all.map(|m| m.1).sum::<f64>() >= SET
    };
    let smallest = (1..=names.len().min(LARGEST_SET)).find(|n| holds(&names[..*n]));
    let set = smallest.filter(|n| *n > 1).map(|n| names[..n].to_vec());
    match set.and_then(|set| Some((with(&[set[0].0])?, set))) {
        Some((model, set)) => Said::Set(model, set),
        None => Said::Unknown(likeliest.cloned()),
    }
}
