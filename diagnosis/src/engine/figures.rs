//! The parameters of a name, each with its 90 % interval on condition that the name is right, and a model as part of a model file.

use super::asked::Asked;
use super::row::Form;
use super::specimen::{SpecimenData, SpecimenModelFit};
use crate::answer::ParameterEstimate;
use crate::interval;
use crate::joint::element::Element;
use crate::joint::{SpecimenFit, figures::figures};
use crate::library::candidate::NamedValue;
use crate::linear::dot;
use crate::model::Model;
use crate::recording::Recording;
use nalgebra::{DMatrix, DVector};
use plant::{Channel, Effect, EffectSpec};

/// Segments whose pulls tell the scatter of what was fitted.
const SEGMENTS: usize = 24;
/// Step of an unknown, relative.
const STEP: f64 = 1e-3;

impl Asked for SpecimenData<'_> {
    type Fit = SpecimenModelFit;

    fn residuals(&self, fit: &SpecimenModelFit, records: &[Recording]) -> Option<Vec<Vec<f64>>> {
        let residual = |r: &Recording| Some(r.residual(r.force_n.as_ref()?, &self.answer(fit, r)?));
        records.iter().map(residual).collect()
    }

    fn figures(&self, fit: &SpecimenModelFit) -> Vec<(Effect, Vec<ParameterEstimate>)> {
        Figures { data: self, fit }.all()
    }

    fn declared(&self, fit: &SpecimenModelFit) -> [f64; 4] {
        fit.declared
    }

    fn save(&self, fit: &SpecimenModelFit, model: &mut Model) {
        Figures { data: self, fit }.save(model);
    }
}

/// A fit's figures.
#[derive(Debug)]
struct Figures<'a, 'b> {
    data: &'a SpecimenData<'b>,
    fit: &'a SpecimenModelFit,
}

/// An unknown of a fit: a declared parameter, the strength of a term, its shape.
#[derive(Clone, Copy, Debug)]
enum Unknown {
    Declared(usize),
    Strength(usize, usize),
    Shape(usize, usize),
}

impl Figures<'_, '_> {
    /// Each name with its parameters.
    fn all(&self) -> Vec<(Effect, Vec<ParameterEstimate>)> {
        let mut names = self.fit.names.clone();
        names.dedup();
        let unknowns = self.unknowns();
        let covariance = self.covariance(&unknowns);
        let of = |name: Effect| {
            let here = self.values(self.fit, name);
            let mut gradient = DMatrix::zeros(here.len(), unknowns.len());
            for (j, unknown) in unknowns.iter().enumerate() {
                let (moved, step) = moved(self.fit, *unknown);
                for (i, there) in self
                    .values(&moved, name)
                    .iter()
                    .enumerate()
                    .take(here.len())
                {
                    gradient[(i, j)] = (there.2 - here[i].2) / step;
                }
            }
            (name, interval::around(here, &gradient, covariance.as_ref()))
        };
        names.into_iter().map(of).collect()
    }

    /// The elements among the terms as the joint search had them, and whose each is.
    fn elements(&self, fit: &SpecimenModelFit) -> (SpecimenFit, Vec<Effect>) {
        let rows = &self.data.rows;
        let mut elements = Vec::new();
        let mut owners = Vec::new();
        let mut freed = [false; 4];
        for ((term, strengths), name) in fit.terms.iter().zip(&fit.strengths).zip(&fit.names) {
            let row = &rows[term.row];
            match row.form {
                Form::Element(law) => {
                    let shape = term.shape;
                    elements.push((Element { law, shape }, strengths[0]));
                    owners.push(*name);
                }
                Form::Parameter(i) => freed[i] = true,
                Form::Effect(_) => {}
            }
            if let Some(i) = row.frees {
                freed[i] = true;
            }
        }
        let own = SpecimenFit {
            parameters: fit.declared,
            moved: freed,
            elements,
            sizes: self.data.sizes.motion,
            cutoff_hz: self.data.cutoff_hz,
        };
        (own, owners)
    }

    /// The parameters of a name.
    fn values(&self, fit: &SpecimenModelFit, name: Effect) -> Vec<NamedValue> {
        let own = fit.names.iter().position(|n| *n == name);
        let Some(first) = own else {
            return Vec::new();
        };
        let term = &fit.terms[first];
        if let Form::Effect(c) = self.data.rows[term.row].form {
            let shapes = (c.shapes)(&self.data.sizes.scales).len();
            return (c.parameters)(
                &fit.strengths[first],
                &term.shape[..shapes],
                &self.data.sizes.scales,
            );
        }
        let (elements, owners) = self.elements(fit);
        let own: Vec<usize> = (0..owners.len()).filter(|&i| owners[i] == name).collect();
        figures(name, &own, &elements, &self.data.declared_values())
    }

    fn unknowns(&self) -> Vec<Unknown> {
        let mut all = Vec::new();
        let bounds = self.data.bounds_of(self.fit);
        let inside = |i: usize, value: f64| {
            let b = bounds[i];
            let room = 1e-6 * (b.high - b.low).min(value.abs());
            value > b.low + room && value < b.high - room
        };
        for i in 0..4 {
            if inside(i, self.fit.declared[i]) {
                all.push(Unknown::Declared(i));
            }
        }
        let mut at = 4;
        for (t, (term, strengths)) in self.fit.terms.iter().zip(&self.fit.strengths).enumerate() {
            for (k, s) in strengths.iter().enumerate() {
                if inside(at + k, *s) && *s != 0.0 {
                    all.push(Unknown::Strength(t, k));
                }
            }
            at += strengths.len();
            let row = &self.data.rows[term.row];
            for (which, _, _) in row.movable(term.shape, &self.data.sizes) {
                all.push(Unknown::Shape(t, which));
            }
        }
        all
    }

    /// How the unknowns vary together, from how far segments of the record pull the fit apart.
    fn covariance(&self, unknowns: &[Unknown]) -> Option<DMatrix<f64>> {
        let n = unknowns.len();
        if n == 0 {
            return None;
        }
        let here = self.data.answered(self.fit);
        let residual = crate::signals::difference(self.data.target(), &here);
        let columns: Vec<Vec<f64>> = unknowns
            .iter()
            .map(|u| {
                let (moved, step) = moved(self.fit, *u);
                crate::signals::difference_quotient(&self.data.answered(&moved), &here, step)
            })
            .collect();
        let size: Vec<f64> = columns
            .iter()
            .map(|c| dot(c, c).max(f64::MIN_POSITIVE).sqrt())
            .collect();
        let bread = DMatrix::from_fn(n, n, |i, j| {
            dot(&columns[i], &columns[j]) / size[i] / size[j] + if i == j { 1e-9 } else { 0.0 }
        });
        let inverse = bread.cholesky()?.inverse();
        let samples = residual.len();
        let mut pulls: DMatrix<f64> = DMatrix::zeros(n, n);
        for k in 0..SEGMENTS {
            let (a, b) = (k * samples / SEGMENTS, (k + 1) * samples / SEGMENTS);
            let pull =
                DVector::from_fn(n, |i, _| dot(&columns[i][a..b], &residual[a..b]) / size[i]);
            pulls += &pull * pull.transpose();
        }
        let free = (SEGMENTS as f64 - n as f64).max(0.5 * SEGMENTS as f64);
        let all = &inverse * pulls * &inverse * (SEGMENTS as f64 / free);
        Some(DMatrix::from_fn(n, n, |i, j| {
            all[(i, j)] / size[i] / size[j]
        }))
    }

    /// Puts the fit into a model: refitted parameters, elements beside the specimen, effects.
    fn save(&self, model: &mut Model) {
        let (elements, owners) = self.elements(self.fit);
        elements.save(&owners, model);
        let Some((_, effects)) = model.channel_mut(Channel::Specimen) else {
            return;
        };
        for (term, strengths) in self.fit.terms.iter().zip(&self.fit.strengths) {
            let Form::Effect(c) = self.data.rows[term.row].form else {
                continue;
            };
            let shapes = (c.shapes)(&self.data.sizes.scales).len();
            let own = (c.parameters)(strengths, &term.shape[..shapes], &self.data.sizes.scales);
            let values: Vec<(&str, f64)> =
                own.iter().map(|(name, _, value)| (*name, *value)).collect();
            effects.push(EffectSpec::new(c.effect, &values));
        }
    }
}

/// A fit with one unknown moved, and by how much.
fn moved(fit: &SpecimenModelFit, unknown: Unknown) -> (SpecimenModelFit, f64) {
    let mut other = fit.clone();
    let place = match unknown {
        Unknown::Declared(i) => &mut other.declared[i],
        Unknown::Strength(t, k) => &mut other.strengths[t][k],
        Unknown::Shape(t, which) => &mut other.terms[t].shape[which],
    };
    let step = STEP * place.abs().max(1e-6);
    *place += step;
    (other, step)
}
