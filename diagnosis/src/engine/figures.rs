//! The parameters of a name, with 90 % intervals conditional on the name being right; a model as part of a model file.

use super::asked::Asked;
use super::row::Form;
use super::specimen::{SpecimenData, SpecimenModelFit};
use super::unknowns::Freedom;
use crate::laws::library::candidate::NamedValue;
use crate::laws::specimen::SpecimenFit;
use crate::laws::specimen::element::Element;
use crate::laws::specimen::figures::{PRESLIDING, figures};
use crate::model::Model;
use crate::model::answer::ParameterEstimate;
use crate::model::interval;
use crate::model::interval::NINETY;
use crate::record::recording::Recording;
use nalgebra::DMatrix;
use plant::{Channel, Effect, EffectSpec};

impl Asked for SpecimenData<'_> {
    type Fit = SpecimenModelFit;

    fn residuals(&self, fit: &SpecimenModelFit, records: &[Recording]) -> Option<Vec<Vec<f64>>> {
        let residual = |r: &Recording| Some(r.residual(r.force_n.as_ref()?, &self.answer(fit, r)?));
        records.iter().map(residual).collect()
    }

    fn settled(&self, fit: &SpecimenModelFit) -> SpecimenModelFit {
        self.settled(fit)
    }

    fn figures(&self, fit: &SpecimenModelFit) -> Vec<(Effect, Vec<ParameterEstimate>)> {
        let own = Figures { data: self, fit }.all();
        if fit.left_out_mm.is_none() {
            return own;
        }
        // Only near a reversal does friction show the travel over which it builds up.
        let whole = SpecimenModelFit {
            left_out_mm: None,
            ..fit.clone()
        };
        let data = self;
        let whole = Figures { data, fit: &whole }.all();
        let which = |(own, whole): (ParameterEstimate, ParameterEstimate)| {
            if own.0 == PRESLIDING { whole } else { own }
        };
        let pairs = own.into_iter().zip(whole);
        pairs
            .map(|((name, own), (_, whole))| {
                (name, own.into_iter().zip(whole).map(which).collect())
            })
            .collect()
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

impl Figures<'_, '_> {
    /// All names with their parameters.
    fn all(&self) -> Vec<(Effect, Vec<ParameterEstimate>)> {
        let mut names: Vec<Effect> = Vec::new();
        for name in &self.fit.names {
            if !names.contains(name) {
                names.push(*name);
            }
        }
        let unknowns = self.unknowns();
        let at = self.data.linearised(self.fit, &unknowns);
        let scatter = at.map(|at| (at.covariance(), self.data.shift(self.fit, &at)));
        let of = |name: Effect| {
            let here = self.values(self.fit, name);
            let mut gradient = DMatrix::zeros(here.len(), unknowns.len());
            for (j, unknown) in unknowns.iter().enumerate() {
                let (moved, step) = unknown.moved(self.fit);
                for (i, there) in self
                    .values(&moved, name)
                    .iter()
                    .enumerate()
                    .take(here.len())
                {
                    gradient[(i, j)] = (there.2 - here[i].2) / step;
                }
            }
            let around = interval::around(here, &gradient, scatter.as_ref());
            (name, self.as_far_as_declared(name, around))
        };
        names.into_iter().map(of).collect()
    }

    /// Widens the interval of a gain, which is relative to a stiffness known only to its tolerance.
    fn as_far_as_declared(
        &self,
        name: Effect,
        mut all: Vec<ParameterEstimate>,
    ) -> Vec<ParameterEstimate> {
        let stiffness = self.data.declared_values()[0];
        if name == Effect::GainError && stiffness != 0.0 {
            let share = NINETY * self.data.tolerance(0) / stiffness.abs();
            for (_, _, error, ci90) in &mut all {
                let known = share * (1.0 + *error);
                let [below, above] = [*error - ci90[0], ci90[1] - *error];
                *ci90 = [*error - below.hypot(known), *error + above.hypot(known)];
            }
        }
        all
    }

    /// The elements among the terms, with the name that each belongs to.
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
        let terms = fit.terms.iter().zip(&fit.strengths).zip(&fit.names);
        for ((term, strengths), _) in terms.filter(|t| *t.1 == name) {
            if let Form::Effect(c) = self.data.rows[term.row].form {
                let scales = self.data.sizes_of(fit).scales;
                let shapes = (c.shapes)(&scales).len();
                return (c.parameters)(strengths, &term.shape[..shapes], &scales);
            }
        }
        let (mut elements, owners) = self.elements(fit);
        if matches!(name, Effect::GainError | Effect::RigCompliance) {
            elements.parameters[0] = self.data.stiffness_of_small_motions(fit);
        }
        let own: Vec<usize> = (0..owners.len()).filter(|&i| owners[i] == name).collect();
        figures(name, &own, &elements, &self.data.declared_values())
    }

    fn unknowns(&self) -> Vec<Freedom> {
        let mut all = self.data.freedoms(self.fit);
        all.retain(|f| f.is_inside(self.fit));
        all
    }

    /// Writes the fit into a model: refitted parameters, elements beside the specimen, effects.
    fn save(&self, model: &mut Model) {
        let (elements, owners) = self.elements(self.fit);
        elements.save(&owners, model);
        let Some((_, effects)) = model.channel_mut(Channel::Specimen) else {
            return;
        };
        let mut terms: Vec<_> = self.fit.terms.iter().zip(&self.fit.strengths).collect();
        // Those of a file act one after the other.
        terms.sort_by_key(|(t, _)| self.data.rows[t.row].point_of_action());
        for (term, strengths) in terms {
            let Form::Effect(c) = self.data.rows[term.row].form else {
                continue;
            };
            let scales = self.data.sizes_of(self.fit).scales;
            let shapes = (c.shapes)(&scales).len();
            let own = (c.parameters)(strengths, &term.shape[..shapes], &scales);
            let values: Vec<(&str, f64)> =
                own.iter().map(|(name, _, value)| (*name, *value)).collect();
            effects.push(EffectSpec::new(c.effect, &values));
        }
    }
}
