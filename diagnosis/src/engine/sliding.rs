//! Reads friction only where it certainly slides.
//!
//! After a reversal friction is still building up, by an unknown law (a spring that slips, bristles, a film of grease).
//! A fit over all samples attributes the error of the assumed law to less friction and more damping, by some percent
//! and with narrow intervals. Near a reversal, noise of the displacement also decides the sign of the speed. So
//! strengths are read from samples far enough from any reversal. How far is seen from the friction's strength itself:
//! it no longer changes when more of the travel is left out.

use super::row::Form;
use super::specimen::{SpecimenData, SpecimenModelFit};
use super::unknowns::{Freedom, Unknown};
use crate::laws::specimen::element::Element;
use plant::Effect;

/// Shortest travel after a reversal that is left out, in yield displacements: a reversed slider slides after two.
const SHORTEST: f64 = 4.0;
/// Ratio of each travel to the one before.
const LONGER: f64 = 1.5;
/// Fraction of the travel after a reversal that is also left out before one: noise shifts where it is seen.
const BEFORE: f64 = 0.25;
/// Smallest fraction of the samples that must remain.
const STAYS: f64 = 0.5;

/// A strength read from some of the samples.
#[derive(Debug)]
struct Reading<T> {
    /// The fit.
    fit: T,
    /// The strength.
    strength: f64,
    /// Its standard error.
    error: f64,
}

/// The first reading, for increasing travels left out, that agrees with all later ones within the scatter of the
/// samples between them; `read` gives a fit, its strength and its error, or `None` if too little is left.
fn agreeing<T>(yield_mm: f64, read: impl Fn(f64) -> Option<(T, f64, f64)>) -> Option<Reading<T>> {
    let travels = std::iter::successors(Some(SHORTEST * yield_mm), |travel| Some(LONGER * travel));
    let reading = |travel_mm| {
        let (fit, strength, error) = read(travel_mm)?;
        Some(Reading {
            fit,
            strength,
            error,
        })
    };
    let mut all: Vec<Reading<T>> = travels.map_while(reading).take(MOST).collect();
    let agrees = |i: &usize| {
        let later = &all[i + 1..];
        later.iter().all(|l| {
            // A reading from some samples scatters about that from all by the root of the difference.
            let more = (l.error.powi(2) - all[*i].error.powi(2)).max(0.0).sqrt();
            (all[*i].strength - l.strength).abs() <= more.max(LEAST * l.error)
        })
    };
    let first = (0..all.len()).find(agrees)?;
    Some(all.swap_remove(first))
}

/// Fraction of a standard error that counts as no difference.
const LEAST: f64 = 0.3;
/// Largest number of readings: from a thousandth of the motion to all of it.
const MOST: usize = 20;

/// 1 where a motion is within a travel after a reversal, or a fraction of it before one.
fn near(x: &[f64], travel_mm: f64) -> Vec<f64> {
    let mut near = vec![0.0; x.len()];
    for (forth, travel_mm) in [(true, travel_mm), (false, BEFORE * travel_mm)] {
        let (mut since, mut speed) = (0.0, 0.0_f64);
        let mut visit = |i: usize, last: usize| {
            let step = x[i] - x[last];
            if step * speed <= 0.0 {
                since = 0.0;
                near[last] = 1.0;
            }
            speed = step;
            since += step.abs();
            if since <= travel_mm {
                near[i] = 1.0;
            }
        };
        if forth {
            (1..x.len()).for_each(|i| visit(i, i - 1));
        } else {
            (0..x.len() - 1).rev().for_each(|i| visit(i, i + 1));
        }
    }
    near
}

impl SpecimenData<'_> {
    /// The fit with strengths from where its friction slides; `None` without friction, or if too little of the motion
    /// is far from a reversal.
    pub fn read_where_it_slides(&self, fit: &SpecimenModelFit) -> Option<SpecimenModelFit> {
        let rubs = |t: &usize| fit.names[*t] == Effect::CoulombFriction;
        let own: Vec<usize> = (0..fit.terms.len()).filter(rubs).collect();
        let yields_at = |t: usize| match self.rows[fit.terms[t].row].form {
            Form::Element(law) if law.slides() => {
                let shape = fit.terms[t].shape;
                Some(Element { law, shape }.yields_at())
            }
            _ => None,
        };
        let yields = own.iter().filter_map(|&t| yields_at(t));
        let yield_mm = yields.fold(0.0, f64::max);
        if yield_mm == 0.0 {
            return None;
        }
        // Far from a reversal, other sliders give the same force as friction: they keep their values from all samples.
        let moves = |f: &Freedom| match f.unknown {
            Unknown::Shape(..) => false,
            Unknown::Strength(t, _) => own.contains(&t) || yields_at(t).is_none(),
            Unknown::Declared(_) => true,
        };
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
            let there = self.settled_by(there, moves);
            let strength = own.iter().map(|&t| there.strengths[t][0]).sum();
            let error = self.error_of(&there, &own);
            Some((there, strength, error))
        })?;
        Some(reading.fit)
    }

    /// Marks samples at least this far from any reversal.
    pub fn far_from_reversals(&self, travel_mm: f64) -> Vec<bool> {
        let near = self.stacked(|m| vec![near(&m.track.x, travel_mm)]);
        near[0].iter().map(|share| *share == 0.0).collect()
    }

    /// Standard error of the sum of some terms' strengths.
    fn error_of(&self, fit: &SpecimenModelFit, terms: &[usize]) -> f64 {
        let mut all = self.freedoms(fit);
        all.retain(|f| f.is_inside(fit) && !matches!(f.unknown, Unknown::Shape(..)));
        let own = |f: &Freedom| matches!(f.unknown, Unknown::Strength(t, _) if terms.contains(&t));
        let Some(at) = self.linearised(fit, &all) else {
            return 0.0;
        };
        let covariance = at.covariance();
        let these: Vec<usize> = (0..all.len()).filter(|i| own(&all[*i])).collect();
        let pairs = these
            .iter()
            .flat_map(|i| these.iter().map(move |j| (*i, *j)));
        let variance: f64 = pairs.map(|place| covariance[place]).sum();
        variance.max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::super::row::Row;
    use super::super::score::Evidence;
    use super::super::specimen::Term;
    use super::*;
    use crate::laws::specimen::element::Law;
    use crate::model::base::Base;
    use crate::model::{Declared, Model, SpecimenModel};
    use crate::record::recording::Recording;
    use plant::Channel;
    use std::f64::consts::PI;

    /// Friction that builds up over millimetres, 9.2 kN, along a sine of 25 mm and 0.5 Hz.
    fn brake() -> Recording {
        let time_s: Vec<f64> = (0..2400).map(|i| f64::from(i) / 256.0).collect();
        let x: Vec<f64> = time_s.iter().map(|t| 25.0 * (PI * t).sin()).collect();
        let (mut last, mut share) = (0.0, 0.0_f64);
        let pulls = |x: &f64| {
            let step = x - last;
            last = *x;
            share += step / 3.0 * (1.0 - share * step.signum());
            9200.0 * share
        };
        Recording {
            force_n: Some(x.iter().map(pulls).collect()),
            displacement_mm: Some(x),
            time_s,
            ..Recording::default()
        }
    }

    #[test]
    fn what_slides_beside_friction_keeps_what_all_samples_say() {
        let declared = |tolerance| {
            Some(Declared {
                value: 0.0,
                tolerance,
            })
        };
        let specimen = SpecimenModel {
            stiffness_n_per_mm: declared(10.0),
            damping_n_s_per_mm: declared(2.0),
            mass_kg: declared(10.0),
            offset_n: declared(300.0),
            ..SpecimenModel::default()
        };
        let model = Model {
            specimen: Some(specimen),
            ..Model::default()
        };
        let base = Base::of(&model, Channel::Specimen).unwrap();
        let mut data = SpecimenData::new(&base, &[brake()]).unwrap();
        data.score.noise = 40.0_f64.powi(2);
        let slides = |r: &Row| matches!(r.form, Form::Element(Law::Slider));
        let mut rows = (0..data.rows.len()).filter(|i| slides(&data.rows[*i]));
        let terms = [0.5, 4.9].map(|yield_mm| Term {
            row: rows.next().unwrap(),
            shape: [yield_mm, 0.0, 0.0, 0.0],
        });
        let fit = SpecimenModelFit {
            terms: terms.to_vec(),
            declared: [0.0; 4],
            strengths: vec![vec![2000.0], vec![6000.0]],
            names: vec![Effect::CoulombFriction, Effect::BilinearHysteresis],
            evidence: Evidence::of_samples(0.0, 0.0),
            acts_on: None,
            left_out_mm: None,
        };
        let all = data.settled_by(fit, |f| !matches!(f.unknown, Unknown::Shape(..)));
        let read = data.read_where_it_slides(&all).unwrap();
        assert!(all.strengths[1][0] > 3000.0, "{:?}", all.strengths);
        assert_eq!(read.strengths[1], all.strengths[1]);
        assert_ne!(read.strengths[0], all.strengths[0]);
    }

    #[test]
    fn the_way_after_a_reversal_is_near_and_a_part_of_it_before() {
        // Up by 10 steps of 1, down again.
        let x: Vec<f64> = (0..21)
            .map(|i| 10.0 - f64::from(i - 10_i32).abs())
            .collect();
        let near = near(&x, 4.0);
        let at: Vec<usize> = (5..20).filter(|i| near[*i] > 0.0).collect();
        assert_eq!(at, [9, 10, 11, 12, 13, 14, 19]);
    }

    #[test]
    fn a_strength_that_settles_is_read_where_it_has_settled() {
        let read = |travel: f64| {
            (travel < 60.0).then(|| (travel, 300.0 - 20.0 * (-travel / 6.0).exp(), 0.5))
        };
        let reading = agreeing(1.0, read).unwrap();
        assert!((reading.strength - 300.0).abs() <= 0.5, "{reading:?}");
        assert!(reading.fit < 40.0, "{reading:?}");
        assert!(agreeing(20.0, read).is_none());
    }
}
