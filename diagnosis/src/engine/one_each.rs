//! The best model with one law of each name: what a next test has to tell apart.

use super::asked::Asked;
use super::search::Search;
use super::specimen::{SpecimenData, SpecimenModelFit, Term};
use crate::base::Base;
use crate::linear::dot;
use crate::model::Model;
use crate::recording::Recording;
use crate::signals::rms;
use crate::specimen::without_known;
use plant::{Channel, Effect};
use rayon::prelude::*;

/// Laws of a name whose shapes are moved to their best.
const POLISHED: usize = 3;
/// What is left below this share of the output's squares counts as nothing.
const NOTHING: f64 = 1e-8;

/// One model for each name that `wanted` lets through, with one law beside the declared parameters, and the rms that it leaves of
/// the training data. Best first.
pub fn one_each(
    model: &Model,
    train: &[Recording],
    wanted: impl Fn(Effect) -> bool + Sync,
) -> Option<Vec<(Effect, Model, f64)>> {
    let base = Base::of(model, Channel::Specimen)?;
    let bare = without_known(&base, train)?;
    let mut data = SpecimenData::new(&base, &bare, &bare)?;
    data.score.noise = NOTHING * dot(data.target(), data.target()) / data.target().len() as f64;
    let (atoms, found) = data.searched_by(|s: &Search| s.alone());
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
    let mut all: Vec<(Effect, Model, f64)> = Vec::new();
    for (name, fit, left) in fits {
        if all.iter().all(|a| a.0 != name) {
            let mut with = model.clone();
            data.save(&data.settled(&fit), &mut with);
            all.push((name, with, left));
        }
    }
    Some(all)
}
