//! The verdict that a posterior allows: what the training data propose. `diagnose/decision.rs` decides on it.

use super::posterior::{Candidate, Name, Posterior};
use plant::{Effect, Family};

/// Structure below the first fraction of the noise is nothing. If no rest determines the noise, so is structure below
/// the second, unless a model contradicts it.
pub const NOTHING: [f64; 2] = [0.42, 0.84];
/// Evidence that counts as contradiction, nats: half of the squares.
pub const SPEAKS: f64 = 5.5;
/// Evidence that contradicts even below the first fraction, nats: only every sample can give so much.
pub const SHOUTS: f64 = 9.0;
/// Lowest probability at which a name is given.
pub const SURE: f64 = 0.72;
/// Lowest probability with which a set contains the cause.
pub const SET: f64 = 0.9;
/// The model of sure names alone is kept unless a larger one is better by this, nats: three fifths of the squares.
pub const LACKS: f64 = 4.0;
/// Lowest probability at which a further name is reported with sure names.
pub const RIVALS: f64 = 0.05;
/// Lowest probability at which a rival of a sure name is reported.
pub const RIVAL: f64 = 0.01;
/// Fraction of the free functions' gain, in log squares, that a name given beside an unnamed part must achieve.
pub const PLAIN: f64 = 0.75;
/// Largest set of names that still says something.
pub const LARGEST_SET: usize = 5;
/// If a model leaves more than this fraction of the noise, a law not in the table may be the cause: of names given as
/// sure, all were right below it and four fifths above (a study on 200 records of two authors).
pub const UNEXPLAINED: f64 = 0.45;
/// Probability that such a law is the cause, below and above. No sample is large enough to promise less than the first.
pub const NOT_IN_THE_TABLE: [f64; 2] = [0.04, 0.2];

/// Names, each with its probability, the likeliest first.
pub type Probabilities<N = Effect> = Vec<(N, f64)>;

/// Names that are given as sure, together.
#[derive(Clone, Debug)]
pub struct Named<M, N = Effect> {
    /// The likeliest model that contains them.
    pub model: Candidate<M, N>,
    /// The names, each with its probability.
    pub names: Probabilities<N>,
    /// For each name, its possible replacements.
    pub rivals: Vec<Probabilities<N>>,
    /// One of these is present in addition to them.
    pub beside: Probabilities<N>,
    /// True if they are not everything: something else is present, named or not.
    pub more: bool,
    /// True if they alone do most of what the model does, and no set of others is sure to be present.
    pub lead: bool,
}

/// The possible verdicts on a channel.
#[derive(Clone, Debug)]
pub enum Said<M, N = Effect> {
    /// Nothing is missing.
    Nothing,
    /// These names are in the channel.
    Names(Named<M, N>),
    /// One of these is in the channel.
    Set(Candidate<M, N>, Probabilities<N>),
    /// Something is missing, but no name can be given; with the likeliest named model.
    Unknown(Option<Candidate<M, N>>),
}

impl<M, N: Name> Said<M, N> {
    /// The likeliest model of what is said.
    pub fn model(&self) -> Option<&Candidate<M, N>> {
        match self {
            Self::Nothing => None,
            Self::Names(named) => Some(&named.model),
            Self::Set(model, _) => Some(model),
            Self::Unknown(model) => model.as_ref(),
        }
    }

    /// The likeliest name.
    pub fn likeliest(&self) -> Option<N> {
        match self {
            Self::Nothing => None,
            Self::Names(Named { names, .. }) | Self::Set(_, names) => names.first().map(|n| n.0),
            Self::Unknown(model) => model.as_ref().and_then(|m| m.names.first().copied()),
        }
    }
}

/// The verdict that a posterior allows. `nothing`: limits over the noise, in any case and without contradiction.
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
    // Free functions do better than any name, but a plain name achieves nearly as much.
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

/// The sure names, with the model that contains them.
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
    // The model of exactly these names, unless it lacks what is present along with them.
    let exact = all().find(|c| c.names.len() == only.len());
    let near = |c: &&Candidate<M, N>| best.evidence.score() - c.evidence.score() < LACKS;
    let model = exact.filter(near).unwrap_or(best).clone();
    let others = model.names.len() > only.len();
    let mut beside = posterior.names();
    beside.retain(|n| others && !only.contains(&n.0) && n.1 >= RIVALS);
    beside.truncate(LARGEST_SET.saturating_sub(only.len()));
    let alone = exact.is_some_and(|c| posterior.explained(c) >= PLAIN);
    let with = |c: &Candidate<M, N>| beside.iter().any(|n| c.names.contains(&n.0));
    let lead = alone && posterior.share(|c| has(&c) && with(c)) < SET;
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

/// Possible replacements of a name that are probable enough to report.
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

/// The smallest set of names of which one is probable enough to be in the rig; else the names of a family that is sure.
fn set<M: Clone, N: Name>(
    posterior: &Posterior<M, N>,
) -> Option<(Candidate<M, N>, Probabilities<N>)> {
    let names = posterior.names();
    let holds =
        |set: &[(N, f64)]| posterior.share(|c| set.iter().any(|n| c.names.contains(&n.0))) >= SET;
    let smallest = (1..=names.len().min(LARGEST_SET)).find(|n| holds(&names[..*n]));
    let set = smallest.filter(|n| *n > 1).map(|n| names[..n].to_vec());
    let set = set.or_else(|| plain_family(posterior, &names))?;
    let has = |c: &&Candidate<M, N>| !c.nameless && c.names.contains(&set[0].0);
    let model = posterior.models.iter().map(|m| &m.0).find(has)?;
    Some((model.clone(), set))
}

/// The names of a family that is sure although none of its names is.
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
