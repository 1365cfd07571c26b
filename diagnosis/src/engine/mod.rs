//! The engine: models a channel as a path, terms and coloured noise, and takes a record to a decision.
//!
//! ```text
//! row, law/  the only table of what may be missing: a row per law, a file per family
//! cutoff     the frequency between motion and noise               motion     a record as the laws see it: columns
//! gram       their products, block by block                       bounded    least squares within bounds
//! score      the only measure: left-out blocks of the training data
//! beam       the only search: a set, one more term at a time      search     sets of laws by their products
//! polish     a model's shapes at their best                       free       the rival without a name
//! exact      if a law leaves noise, every sample counts           naming     a fit under each name of its force
//! posterior  the probability of each name                         verdict    what they allow to propose
//! settle     the chosen model fitted down to the noise            sliding    friction where it slides
//! unknowns   what a fit may move, with its covariance             figures    a name's parameters with intervals
//! elsewhere  another cut-off, judged with what was found          asked      what an answer needs from a channel
//! one_each   one model per name, for the next test
//! ```
//!
//! The engine expects records that were checked and resampled (`record/`, `prepare/plausible.rs`), without what the
//! model already explains (`prepare/known.rs`); a noise that is the transducer's and the declared model's response to
//! it, no disturbance (`prepare/noise.rs`); and that what follows a verdict searches no laws (`diagnose.rs`). Notes,
//! remainder, error intervals and saving use a [`SpecimenModelFit`] and its residuals. The same search, posterior and
//! verdict find wrong matrix entries of several coordinates (`diagnose/coupled/select.rs`): there a name is an entry.

mod actuator;
mod asked;
pub mod beam;
mod cutoff;
pub mod drivetrain;
mod elsewhere;
mod exact;
mod figures;
mod free;
mod gram;
mod law;
mod motion;
mod naming;
mod one_each;
mod polish;
pub mod posterior;
mod row;
mod save;
pub mod score;
mod search;
mod settle;
mod sliding;
mod specimen;
mod unknowns;
pub mod verdict;

pub use actuator::{ActuatorChannel, actuator};
pub use asked::{Asked, Found, OfOneName};
pub use one_each::each;
pub use posterior::Candidate;
pub use score::KnownNoise;
pub use specimen::{SpecimenData, SpecimenModelFit};
pub use verdict::{Named, SURE, Said};

use naming::candidates;
use rayon::prelude::*;
use score::raised;
use search::{Scored, Search};
use specimen::Term;

/// Number of models whose shapes are refined.
const POLISHED: usize = 24;
/// Number of models by least squares whose shapes are refined, too.
const BY_SQUARES: usize = 8;
/// Number of leading models that are also tried with one term less.
const ASKED_FOR_LESS: usize = 5;
/// Largest distance of a refined model below the best score, nats.
const FAR_BELOW: f64 = 14.0;

/// Number of leading models that are also tried with free functions added.
const BESIDE_FREE: usize = 10;
/// Most names of a model that describes a rig down to the noise by more than chance.
const DESCRIBE: usize = 2;
/// Price of a law without a name beyond that of such a model, nats: one rig in twenty.
const NAMED_INSTEAD: f64 = 3.0;

/// Searches a specimen's channel and decides; `None` if no model can be fitted. What was found at another cut-off is tried in
/// any case.
pub fn specimen(
    data: &mut SpecimenData,
    noise: KnownNoise,
    before: Option<&SpecimenModelFit>,
) -> Option<Found<SpecimenModelFit>> {
    data.score.noise = noise.variance.max(f64::MIN_POSITIVE);
    let both = |s: &Search| {
        let found = s.run();
        let by_squares = s.run_by_squares(&found);
        (found, by_squares)
    };
    let (atoms, (mut found, mut by_squares)) = data.searched(both);
    if !noise.told {
        let quiet = found.iter().map(|s| s.evidence.quiet());
        let raised = raised(quiet.fold(f64::INFINITY, f64::min));
        if raised > 1.0 {
            data.score.noise *= raised;
            (found, by_squares) = data.searched(both).1;
        }
    }
    let terms = |s: &Scored| s.atoms.iter().map(|a| Term::of(&atoms[*a])).collect();
    let by_squares = by_squares.iter().take(BY_SQUARES).map(terms);
    let before = before.map(|fit| fit.terms.clone());
    let more = by_squares.chain(before);
    let mut fits = polished(data, &atoms, &found, more)?;
    fits.push(data.polished(&[])?);
    data.weigh_samples(&mut fits);
    let declared = fits.last()?.clone();
    fits.retain(|fit| !data.moves_at_a_limit(fit));
    let mut all = nameless(data, &fits[..fits.len() - 1], &declared, noise.told);
    all.extend(fits.into_iter().flat_map(|f| candidates(data, f)));
    Some(Found::of(all, declared, noise.told))
}

/// The declared model and the leading ones, each with free functions added.
fn nameless(
    data: &SpecimenData,
    fits: &[SpecimenModelFit],
    declared: &SpecimenModelFit,
    told: bool,
) -> Vec<Candidate<SpecimenModelFit>> {
    let mut leading: Vec<&SpecimenModelFit> = fits.iter().collect();
    leading.sort_by(|a, b| b.evidence.score().total_cmp(&a.evidence.score()));
    leading.truncate(BESIDE_FREE);
    leading.push(declared);
    let free = data.free();
    let beside = |fit: &&SpecimenModelFit| {
        let mut evidence = data.beside_free(fit, &free)?;
        evidence.against = fit.evidence.against;
        Some(SpecimenModelFit {
            evidence,
            ..(*fit).clone()
        })
    };
    let mut fits: Vec<_> = leading.par_iter().filter_map(beside).collect();
    // One or two names that leave nothing but noise are likelier than a law without a name.
    let described = leading.iter().filter(|f| {
        let mut names = f.names.clone();
        names.sort_by_key(|n| *n as usize);
        names.dedup();
        (1..=DESCRIBE).contains(&names.len()) && f.evidence.left_rms() < exact::ONE_OF_THE_TABLE
    });
    let price = described.map(|f| f.evidence.price);
    let price = NAMED_INSTEAD + price.fold(f64::INFINITY, f64::min);
    if told && price.is_finite() {
        fits.iter_mut()
            .for_each(|f| f.evidence.price = f.evidence.price.max(price));
    }
    let mut all: Vec<_> = fits.into_iter().flat_map(|f| candidates(data, f)).collect();
    all.iter_mut().for_each(|c| c.nameless = true);
    all
}

/// The leading models and `more` with refined shapes, and the best of them with one term less, or with a range in place of a
/// spring that softens.
fn polished(
    data: &SpecimenData,
    atoms: &[search::Atom],
    found: &[Scored],
    more: impl Iterator<Item = Vec<Term>>,
) -> Option<Vec<SpecimenModelFit>> {
    let best = found.first()?.evidence.score();
    let near = |s: &&Scored| s.evidence.score() > best - FAR_BELOW;
    let term = |&a: &usize| Term::of(&atoms[a]);
    let mut starts: Vec<Vec<Term>> = found
        .iter()
        .filter(near)
        .take(POLISHED)
        .map(|s| s.atoms.iter().map(term).collect())
        .collect();
    starts.retain(|s| !s.is_empty());
    let singles = found
        .iter()
        .filter(|s| s.atoms.len() == 1)
        .take(beam::ALONE);
    let singles = singles.map(|s| s.atoms.iter().map(term).collect::<Vec<_>>());
    for start in singles.chain(more) {
        if !starts.contains(&start) {
            starts.push(start);
        }
    }
    let all = |starts: Vec<Vec<Term>>| -> Vec<SpecimenModelFit> {
        let fits = starts.into_par_iter().filter_map(|s| data.polished(&s));
        fits.collect()
    };
    let mut fits = all(starts);
    fits.sort_by(|a, b| b.evidence.score().total_cmp(&a.evidence.score()));
    // Start from the refined shapes.
    let leading = fits
        .iter()
        .take(ASKED_FOR_LESS)
        .filter(|f| f.terms.len() > 1);
    let others = leading.flat_map(|f| {
        let fewer = (0..f.terms.len()).map(|out| {
            let mut terms = f.terms.clone();
            terms.remove(out);
            terms
        });
        fewer.chain(data.with_a_range(f))
    });
    let others = all(others.collect());
    fits.extend(others);
    Some(fits)
}

/// The credible fraction of a stated probability: the residual tells whether a law not in the table may be the cause.
pub fn trust(evidence: &score::Evidence) -> f64 {
    let [below, above] = verdict::NOT_IN_THE_TABLE;
    let share = if evidence.left_rms() < verdict::UNEXPLAINED {
        below
    } else {
        above
    };
    1.0 - share
}
