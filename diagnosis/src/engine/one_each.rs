//! The best model with one law for each name: what a next test has to tell apart.

use super::actuator::actuator_each;
use super::asked::{Asked, OfOneName};
use super::search::Search;
use super::specimen::{SpecimenData, SpecimenModelFit, Term};
use crate::model::Model;
use crate::model::base::Base;
use crate::numbers::linear::dot;
use crate::numbers::signals::rms;
use crate::prepare::known::without_known;
use crate::record::recording::Recording;
use plant::{Channel, Effect};
use rayon::prelude::*;

/// Number of laws per name whose shapes are refined.
const POLISHED: usize = 3;
/// A residual below this fraction of the output's squares counts as nothing.
const NOTHING: f64 = 1e-8;

/// One model per name accepted by `wanted`, best first; of each name the form with the smallest residual.
pub fn each(
    model: &Model,
    channel: Channel,
    train: &[Recording],
    wanted: impl Fn(Effect) -> bool + Sync,
) -> Vec<OfOneName> {
    let all = match channel {
        Channel::Specimen => specimen_each(model, train, wanted),
        Channel::Actuator => actuator_each(model, train, &wanted),
    };
    let mut all = all.unwrap_or_default();
    all.sort_by(|a, b| a.left_rms.total_cmp(&b.left_rms));
    let mut names: Vec<Effect> = Vec::new();
    all.retain(|f| {
        let new = !names.contains(&f.name);
        names.push(f.name);
        new
    });
    all
}

fn specimen_each(
    model: &Model,
    train: &[Recording],
    wanted: impl Fn(Effect) -> bool + Sync,
) -> Option<Vec<OfOneName>> {
    let base = Base::of(model, Channel::Specimen)?;
    let bare = without_known(&base, train)?;
    let mut data = SpecimenData::new(&base, &bare)?;
    data.score.noise = NOTHING * dot(data.target(), data.target()) / data.target().len() as f64;
    let (atoms, found) = data.searched(|s: &Search| s.alone());
    let mut starts: Vec<(Effect, Term)> = Vec::new();
    for atom in found.iter().filter_map(|s| atoms.get(*s.atoms.first()?)) {
        let name = data.rows[atom.row].name(atom.shape, 1.0, &data.sizes);
        let own = starts.iter().filter(|s| s.0 == name).count();
        if own < POLISHED {
            starts.push((name, Term::of(atom)));
        }
    }
    let fits = starts.par_iter().filter_map(|(_, term)| {
        let fit = data.polished(std::slice::from_ref(term))?;
        let name = *fit.names.first()?;
        let left = rms(&data.residuals(&fit, &bare)?);
        (wanted(name) && left.is_finite()).then_some((name, fit, left))
    });
    let mut fits: Vec<(Effect, SpecimenModelFit, f64)> = fits.collect();
    fits.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut all: Vec<OfOneName> = Vec::new();
    for (name, fit, left) in fits {
        // Settling is slow.
        if all.iter().all(|a| a.name != name) {
            all.push(OfOneName::of(&data, &fit, name, model, left));
        }
    }
    Some(all)
}
