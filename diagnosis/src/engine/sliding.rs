//! Friction is read where it slides for certain ([`crate::sliding`]): strengths of a fit, and the declared parameters beside them.

use super::row::Form;
use super::specimen::{SpecimenData, SpecimenModelFit};
use super::unknowns::{Freedom, Unknown};
use crate::joint::element::Element;
use crate::sliding::{STAYS, agreeing, near};
use plant::Effect;

impl SpecimenData<'_> {
    /// The same fit with its strengths from where its friction slides; `None` without friction, and where too little of the motion is
    /// far from a reversal.
    pub fn read_where_it_slides(&self, fit: &SpecimenModelFit) -> Option<SpecimenModelFit> {
        let rubs = |t: &usize| fit.names[*t] == Effect::CoulombFriction;
        let own: Vec<usize> = (0..fit.terms.len()).filter(rubs).collect();
        let yields = own
            .iter()
            .filter_map(|&t| match self.rows[fit.terms[t].row].form {
                Form::Element(law) if law.slides() => {
                    let shape = fit.terms[t].shape;
                    Some(Element { law, shape }.yields_at())
                }
                _ => None,
            });
        let yield_mm = yields.fold(0.0, f64::max);
        if yield_mm == 0.0 {
            return None;
        }
        let reading = agreeing(yield_mm, |travel_mm| {
            let sure = self.far_from_reversals(travel_mm);
            let stay = sure.iter().filter(|s| **s).count() as f64;
            if stay < STAYS * sure.len() as f64 {
                return None;
            }
            let there = SpecimenModelFit {
                left_out_mm: Some(travel_mm),
                ..fit.clone()
            };
            let there = self.settled_by(there, |f| !matches!(f.unknown, Unknown::Shape(..)));
            let strength = own.iter().map(|&t| there.strengths[t][0]).sum();
            let error = self.error_of(&there, &own);
            Some((there, strength, error))
        })?;
        Some(reading.fit)
    }

    /// Samples that are so far from any reversal.
    pub fn far_from_reversals(&self, travel_mm: f64) -> Vec<bool> {
        let near = self.stacked(|m| vec![near(&m.track.x, travel_mm)]);
        near[0].iter().map(|share| *share == 0.0).collect()
    }

    /// Standard error of the sum of some terms' strengths.
    fn error_of(&self, fit: &SpecimenModelFit, terms: &[usize]) -> f64 {
        let mut all = self.freedoms(fit);
        all.retain(|f| f.is_inside(fit) && !matches!(f.unknown, Unknown::Shape(..)));
        let own = |f: &Freedom| matches!(f.unknown, Unknown::Strength(t, _) if terms.contains(&t));
        let Some(covariance) = self.covariance(fit, &all) else {
            return 0.0;
        };
        let at: Vec<usize> = (0..all.len()).filter(|i| own(&all[*i])).collect();
        let pairs = at.iter().flat_map(|i| at.iter().map(move |j| (*i, *j)));
        let variance: f64 = pairs.map(|place| covariance[place]).sum();
        variance.max(0.0).sqrt()
    }
}
