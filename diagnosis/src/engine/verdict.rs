//! The decision on a posterior. What may follow it stands in its order in `diagnose.rs`, and names nothing new: it takes a verdict back,
//! widens it to a set, or lays what has no name to the noise.

use super::posterior::{Candidate, Name, Posterior};
use plant::{Effect, Family};

/// Structure below the first share of the noise is nothing. Where no rest tells the noise, below the second, too, unless a model
/// speaks against it.
pub const NOTHING: [f64; 2] = [0.42, 0.84];
/// By so much, nats: half of the squares.
pub const SPEAKS: f64 = 5.5;
/// Below the first share, too, where every sample says so: by so much, nats.
pub const SHOUTS: f64 = 9.0;
/// A name is given that is at least so probable.
pub const SURE: f64 = 0.72;
/// A set holds the cause with at least this probability.
pub const SET: f64 = 0.9;
/// The model of sure names alone stands where another that has more is better by less than this, nats: three fifths of the squares.
pub const LACKS: f64 = 4.0;
/// What stands beside sure names with at least this probability.
pub const RIVALS: f64 = 0.05;
/// What may stand in the place of a sure name with at least this probability is said.
pub const RIVAL: f64 = 0.01;
/// The share of what free functions take, in the logarithm of the squares, that a name must take to be given beside what has none.
pub const PLAIN: f64 = 0.75;
/// A set of more names says nothing.
pub const LARGEST_SET: usize = 5;
/// Where a model leaves more than this share of the noise, a law that is not in the table may be the cause: of names that were given
/// for sure, all were right below it and four fifths above (a study on 200 records of two authors).
pub const UNEXPLAINED: f64 = 0.45;
/// The probability that such a law is the cause, below and above. No sample is large enough to promise less than the first.
pub const NOT_IN_THE_TABLE: [f64; 2] = [0.04, 0.2];

/// Names, each with its probability, the likeliest first.
pub type Probabilities<N = Effect> = Vec<(N, f64)>;

/// Names without which nothing is said, taken as a whole.
#[derive(Clone, Debug)]
pub struct Named<M, N = Effect> {
    /// The likeliest model that has them.
    pub model: Candidate<M, N>,
    /// The names, each with its probability.
    pub names: Probabilities<N>,
    /// Of each, what may be there in its place.
    pub rivals: Vec<Probabilities<N>>,
    /// One of these stands beside them, too.
    pub beside: Probabilities<N>,
    /// They are not all: something else is there, with a name or without.
    pub more: bool,
    /// They alone do most of what the model does; else what is open beside them is the larger part.
    pub lead: bool,
}

/// What can be said of a channel.
#[derive(Clone, Debug)]
pub enum Said<M, N = Effect> {
    /// Nothing is missing.
    Nothing,
    /// These names are in it.
    Names(Named<M, N>),
    /// One of these is in it.
    Set(Candidate<M, N>, Probabilities<N>),
    /// Something is, and no name can be given; the likeliest one's model.
    Unknown(Option<Candidate<M, N>>),
}

/// What a posterior allows to be said. What counts as nothing, over the noise: in any case, and where no model speaks against it.
pub fn verdict<M: Clone, N: Name>(posterior: &Posterior<M, N>, nothing: [f64; 2]) -> Said<M, N> {
    if posterior
        .declared()
        .is_some_and(|c| is_nothing(posterior, c, nothing))
    {
        return Said::Nothing;
    }
    let said =
        names(posterior).or_else(|| set(posterior).map(|(model, set)| Said::Set(model, set)));
    if let Some(said) = said {
        return said;
    }
    // Free functions do better than any name, and a plain name does nearly all that they do.
    let named = posterior.named();
    let likeliest = named
        .models
        .iter()
        .map(|m| &m.0)
        .find(|c| !c.names.is_empty());
    let plain = named.with_as_few_names(|c| posterior.explained(c) >= PLAIN);
    let Some(plain) = plain else {
        return Said::Unknown(likeliest.cloned());
    };
    match names(&plain) {
        Some(Said::Names(n)) => Said::Names(Named { more: true, ..n }),
        _ => set(&plain).map_or(Said::Unknown(likeliest.cloned()), |(model, set)| {
            Said::Set(model, set)
        }),
    }
}

fn is_nothing<M: Clone, N: Name>(
    posterior: &Posterior<M, N>,
    declared: &Candidate<M, N>,
    [sure, most]: [f64; 2],
) -> bool {
    let best = posterior.models.first().map(|m| m.0.evidence.score());
    let left = declared.evidence.left_rms();
    let by = best.map_or(0.0, |best| best - declared.evidence.score());
    left < sure && by < SHOUTS || left < most && by < SPEAKS
}

/// Names that are sure, with the model that has them.
fn names<M: Clone, N: Name>(posterior: &Posterior<M, N>) -> Option<Said<M, N>> {
    let mut names = posterior.names();
    names.retain(|n| n.1 >= SURE);
    let only: Vec<N> = names.iter().map(|n| n.0).collect();
    let has = |c: &&Candidate<M, N>| !c.nameless && only.iter().all(|n| c.names.contains(n));
    let all = || posterior.models.iter().map(|m| &m.0).filter(has);
    if only.is_empty() {
        return None;
    }
    let best = all().next()?;
    // The model of exactly these names, unless it lacks what is there beside them.
    let exact = all().find(|c| c.names.len() == only.len());
    let near = |c: &&Candidate<M, N>| best.evidence.score() - c.evidence.score() < LACKS;
    let lead = exact.is_some_and(|c| posterior.explained(c) >= PLAIN);
    let model = exact.filter(near).unwrap_or(best).clone();
    let others = model.names.len() > only.len();
    let mut beside = posterior.names();
    beside.retain(|n| others && !only.contains(&n.0) && n.1 >= RIVALS);
    beside.truncate(LARGEST_SET.saturating_sub(only.len()));
    let rivals = only.iter().map(|n| rivals(posterior, *n, &only));
    Some(Said::Names(Named {
        more: others || model.only_family,
        model,
        rivals: rivals.collect(),
        names,
        beside,
        lead,
    }))
}

/// What may stand in the place of a name, with a probability that is worth a word.
fn rivals<M: Clone, N: Name>(
    posterior: &Posterior<M, N>,
    name: N,
    names: &[N],
) -> Probabilities<N> {
    let mut rivals = posterior.rivals(name, names);
    rivals.retain(|r| r.1 >= RIVAL);
    rivals.truncate(LARGEST_SET);
    rivals
}

/// The smallest set of names one of which is in the rig with enough probability; else those of a family that is sure.
fn set<M: Clone, N: Name>(
    posterior: &Posterior<M, N>,
) -> Option<(Candidate<M, N>, Probabilities<N>)> {
    let names = posterior.names();
    let holds = |set: &[(N, f64)]| {
        let hit = |c: &Candidate<M, N>| set.iter().any(|n| c.names.contains(&n.0));
        let all = posterior.models.iter().filter(|m| hit(&m.0));
        all.map(|m| m.1).sum::<f64>() >= SET
    };
    let smallest = (1..=names.len().min(LARGEST_SET)).find(|n| holds(&names[..*n]));
    let set = smallest.filter(|n| *n > 1).map(|n| names[..n].to_vec());
    let set = set.or_else(|| plain_family(posterior, &names))?;
    let has = |c: &&Candidate<M, N>| !c.nameless && c.names.contains(&set[0].0);
    let model = posterior.models.iter().map(|m| &m.0).find(has)?;
    Some((model.clone(), set))
}

/// Names of one family, where the family is sure and none of its names is.
fn plain_family<M: Clone, N: Name>(
    posterior: &Posterior<M, N>,
    names: &[(N, f64)],
) -> Option<Probabilities<N>> {
    let mut families: Vec<Family> = names.iter().filter_map(|n| n.0.family()).collect();
    families.sort_by_key(|f| *f as usize);
    families.dedup();
    let sure = families
        .into_iter()
        .find(|f| posterior.family(*f) >= SURE)?;
    let mut own: Probabilities<N> = names.to_vec();
    own.retain(|n| n.0.family() == Some(sure));
    own.truncate(LARGEST_SET);
    (own.len() > 1).then_some(own)
}
