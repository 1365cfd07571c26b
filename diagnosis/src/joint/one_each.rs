//! The best model with one element of each name: what a next test has to tell apart.

use super::cutoff;
use super::fit::SpecimenFit;
use super::known::without_known;
use super::polish::polish;
use super::search::restrict;
use super::set::{DECLARED, ElementSet, Library};
use super::track::{Track, UnfilteredSpan, thinning};
use crate::base::Base;
use crate::recording::Recording;
use plant::{Channel, Effect};
use rayon::prelude::*;

/// Elements of a name that are polished.
const POLISHED: usize = 3;

/// One model for each name that `wanted` lets through, with one element beside the declared parameters or with one of
/// these outside its tolerance, and the rms that it leaves of the training data. Best first.
pub fn one_each(
    base: &Base,
    train: &[Recording],
    wanted: impl Fn(Effect) -> bool + Sync,
) -> Option<Vec<(Effect, SpecimenFit, f64)>> {
    let bare = without_known(base, train)?;
    let sources: Vec<UnfilteredSpan> = bare
        .iter()
        .map(UnfilteredSpan::new)
        .collect::<Option<_>>()?;
    let cutoff_hz = cutoff::choose(base, &sources, &sources, None, cutoff::Derivatives::Free)?;
    let tracks: Vec<Track> = sources.iter().map(|s| s.track(cutoff_hz)).collect();
    let mut library = Library::new(base, &tracks, thinning(&tracks, cutoff_hz))?;
    let mut scored: Vec<(Effect, ElementSet, f64)> = (0..library.elements.len())
        .into_par_iter()
        .flat_map_iter(|e| named(&library, e))
        .filter(|(name, ..)| wanted(*name))
        .collect();
    scored.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut all = Vec::new();
    let mut names: Vec<Effect> = Vec::new();
    for (name, ..) in &scored {
        if !names.contains(name) {
            names.push(*name);
        }
    }
    for name in names {
        let own = scored.iter().filter(|s| s.0 == name).take(POLISHED);
        let best = own
            .map(|(_, set, score)| polish(&library, set, *score))
            .min_by(|a, b| a.score.total_cmp(&b.score))?;
        let set = library.add_polished(&best);
        let settled = restrict(&library, vec![(set.clone(), best.score)]);
        let with = settled.into_iter().find(|s| !s.0.elements.is_empty());
        let set = with.map_or(set, |s| s.0);
        all.push((name, SpecimenFit::new(&library, &set, cutoff_hz)?));
    }
    for (i, name) in Channel::Specimen.mistakes().into_iter().enumerate() {
        if wanted(name) {
            let set = ElementSet::default().toggled(i);
            all.push((name, SpecimenFit::new(&library, &set, cutoff_hz)?));
        }
    }
    let mut left: Vec<(Effect, SpecimenFit, f64)> = all
        .into_iter()
        .filter_map(|(name, fit)| {
            let left = crate::signals::rms(&fit.residuals(&bare)?);
            Some((name, fit, left))
        })
        .collect();
    left.sort_by(|a, b| a.2.total_cmp(&b.2));
    Some(left)
}

/// An element alone, declared parameters within their tolerances and free, with its name and its score.
fn named(library: &Library, element: usize) -> Vec<(Effect, ElementSet, f64)> {
    let held = ElementSet::default().with(element);
    let free = ElementSet {
        moved: [true; DECLARED],
        ..held.clone()
    };
    [held, free]
        .into_iter()
        .filter_map(|set| {
            let score = library.quick_score(&set)?;
            let strength = library.strengths(&set)?[DECLARED];
            let name = library.elements[element].name(&library.sizes, strength);
            (strength != 0.0).then_some((name, set, score))
        })
        .collect()
}
