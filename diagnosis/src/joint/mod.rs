//! Elements beside the declared specimen, of free strength and up to four together: a joint search on data that leave
//! one block out at a time, and a certificate for each name.
//!
//! The steps of a record: [`band`] and [`cutoff`] (what is motion and what is noise), [`track`] (the motion before the span,
//! for what has a memory), [`dictionary`] of [`element`]s, [`blocks`] (all scalar products, after which the data are not
//! needed any more), [`search`], [`polish`] (shapes), [`certificate`] (which of the names can be vouched for).

mod band;
mod blocks;
mod certificate;
mod covariance;
mod curvature;
pub(crate) mod cutoff;
mod dashpot;
mod dictionary;
pub(crate) mod element;
pub(crate) mod figures;
mod fit;
mod free_functions;
mod groups;
mod kind;
mod known;
mod laws;
mod one_each;
pub(crate) mod outcome;
mod polish;
mod refine;
mod save;
mod search;
mod separable;
mod set;
mod shape;
mod sliding;
pub(crate) mod track;
mod unnamed;

pub use figures::{GAINED, KNEE, PINCHED, STIFFNESS_BEYOND, WORN_TRAVEL};
pub use fit::SpecimenFit;
pub use free_functions::Doubt;
pub use known::without_known;
pub use one_each::one_each;
pub use outcome::{Explained, SpecimenOutcome, q};
pub(crate) use set::declared_columns;
pub(crate) use shape::Scale;

use crate::base::Base;
use crate::criteria::POLISHED;
use crate::recording::Recording;
use crate::rest;
use cutoff::Derivatives;
use plant::{Effect, Family};
use rayon::prelude::*;
use set::{ElementSet, Library};
use track::{Track, UnfilteredSpan, thinning};

/// Whether there is an element or a declared parameter of this name.
pub fn can_say(name: Effect) -> bool {
    !matches!(
        name.entry().family,
        Family::Interference | Family::Limit | Family::Timing
    ) && !matches!(name, Effect::TemperatureGain | Effect::RigCompliance)
}

/// What the search came to.
#[derive(Debug)]
pub struct SpecimenResult {
    /// The declared model, its parameters within their tolerances.
    pub declared: SpecimenFit,
    /// What can be said.
    pub outcome: SpecimenOutcome,
    /// Names that no other name comes near, and that are not given: a free function does.
    pub doubts: Vec<(Effect, Doubt)>,
}

/// Searches; `None` where a signal is missing or the equations have no solution.
pub fn find(base: &Base, train: &[Recording], test: &[Recording]) -> Option<SpecimenResult> {
    let rests = train.iter().all(|r| rest::spans(r).len() == 2);
    let train: Vec<Recording> = train.iter().map(rest::without).collect();
    let sources: Vec<UnfilteredSpan> = train
        .iter()
        .map(UnfilteredSpan::new)
        .collect::<Option<_>>()?;
    let held_out: Vec<UnfilteredSpan> = test
        .iter()
        .map(UnfilteredSpan::new)
        .collect::<Option<_>>()?;
    let mut cutoff_hz = cutoff::choose(base, &sources, &held_out, None, Derivatives::Free)?;
    let tracks: Vec<Track> = sources.iter().map(|s| s.track(cutoff_hz)).collect();
    let mut library = Library::new(base, &tracks, thinning(&tracks, cutoff_hz))?;
    let mut best = searched(&library)?;
    let again_hz = cutoff::choose(
        base,
        &sources,
        &held_out,
        Some(&best.elements),
        Derivatives::Free,
    )?;
    let other: Vec<Track>;
    if again_hz != cutoff_hz && !best.elements.is_empty() {
        other = sources.iter().map(|s| s.track(again_hz)).collect();
        let second = Library::new(base, &other, thinning(&other, again_hz))?;
        let found = searched(&second)?;
        if found.squares < best.squares {
            (best, library, cutoff_hz) = (found, second, again_hz);
        }
    }
    if let Some(finer) = refine::refine(&mut library, &best, searched) {
        best = finer;
    }
    library.rests = rests;
    let (set, names) = certificate::certify(&mut library, &best);
    let declared = SpecimenFit::new(&library, &ElementSet::default(), cutoff_hz)?;
    let outcome = outcome::conclude(&mut library, &set, &names, cutoff_hz)?;
    let doubts = names.iter().filter_map(|n| Some((n.name, n.free.doubt?)));
    Some(SpecimenResult {
        declared,
        outcome,
        doubts: doubts.collect(),
    })
}

/// The best set of a library, its shapes at their best.
fn searched(library: &Library) -> Option<polish::Polished> {
    let leading = search::search(library);
    let polished = leading
        .par_iter()
        .take(POLISHED)
        .map(|(set, score)| polish::polish(library, set, *score));
    polished.min_by(|a, b| a.score.total_cmp(&b.score))
}
