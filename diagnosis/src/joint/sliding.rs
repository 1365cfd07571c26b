//! Friction of the joint search, read where it slides for certain ([`crate::sliding`]), and the way in which it builds up: that
//! is told by the work of the samples that are left out.

use super::blocks::{Blocks, Term};
use super::covariance::{FitUnknown, SANDWICH, chosen, covariance, unknowns};
use super::element::{Element, Law};
use super::fit::SpecimenFit;
use super::set::{DECLARED, ElementSet, Library, column, declared_columns};
use super::track::Track;
use crate::interval::NINETY;
use crate::sliding::{STAYS, agreeing, near};
use plant::Effect;

/// A fit whose strengths come from where its friction slides.
#[derive(Debug)]
pub struct Sliding {
    /// The fit.
    pub fit: SpecimenFit,
    /// Samples of the library that it comes from.
    pub sure: Vec<bool>,
    /// The travel after a reversal that is left out, mm.
    pub travel_mm: f64,
    /// The displacement over which the friction builds up, mm, with its 90 % interval, where one slider is the friction.
    pub presliding_mm: Option<(f64, [f64; 2])>,
}

/// Reads the strengths of a set anew; `None` without friction, and where too little of the motion is far from a reversal.
/// `named` are its names and whose each element of the fit is.
pub fn read(
    library: &Library,
    set: &ElementSet,
    fit: &SpecimenFit,
    named: &[(Effect, Vec<usize>)],
) -> Option<Sliding> {
    let own = named.iter().find(|n| n.0 == Effect::CoulombFriction)?;
    let yields = own.1.iter().map(|&e| fit.elements[e].0.yields_at());
    let yield_mm = yields.fold(0.0, f64::max);
    let reading = agreeing(yield_mm, |travel_mm| {
        let sure = far_from_reversals(library, travel_mm)?;
        let fit = refitted(library, set, fit, &sure)?;
        let strength: f64 = own.1.iter().map(|&e| fit.elements[e].1).sum();
        let error = error_of(library, &fit, &sure, &own.1);
        Some(((fit, sure), strength, error))
    })?;
    let relative = reading.error / reading.strength;
    let (fit, sure) = reading.fit;
    let mut best = Sliding {
        fit,
        sure,
        travel_mm: reading.travel_mm,
        presliding_mm: None,
    };
    if let [e] = own.1[..]
        && matches!(best.fit.elements[e].0.law, Law::Slider | Law::Bristles)
    {
        best.presliding_mm = presliding(library, &best, e, relative);
        if let Some((travel, _)) = best.presliding_mm {
            best.fit.elements[e].0.shape[0] = travel;
        }
    }
    Some(best)
}

/// Standard error of the sum of some elements' strengths.
fn error_of(library: &Library, fit: &SpecimenFit, sure: &[bool], elements: &[usize]) -> f64 {
    let all = unknowns(library, fit);
    let own = |u: &FitUnknown| matches!(u, FitUnknown::Strength(e) if elements.contains(e));
    let Some(covariance) = covariance(library, fit, &all, Some(sure)) else {
        return 0.0;
    };
    let at: Vec<usize> = (0..all.len()).filter(|i| own(&all[*i])).collect();
    let pairs = at.iter().flat_map(|i| at.iter().map(move |j| (*i, *j)));
    let variance: f64 = pairs.map(|place| covariance[place]).sum();
    variance.max(0.0).sqrt()
}

/// The samples that are so far from any reversal; `None` where they are too few.
fn far_from_reversals(library: &Library, travel_mm: f64) -> Option<Vec<bool>> {
    let near = column(library.tracks, library.every, |t| near(&t.x, travel_mm));
    let sure: Vec<bool> = near.iter().map(|share| *share == 0.0).collect();
    let stay = sure.iter().filter(|s| **s).count() as f64;
    (stay >= STAYS * sure.len() as f64).then_some(sure)
}

/// The same model with its strengths from some of the samples.
fn refitted(
    library: &Library,
    set: &ElementSet,
    fit: &SpecimenFit,
    sure: &[bool],
) -> Option<SpecimenFit> {
    let terms = library.terms(set);
    let columns: Vec<Vec<f64>> = terms
        .iter()
        .map(|t| chosen(&library.columns[t.0], sure))
        .collect();
    let blocks = Blocks::new(&columns, &chosen(&library.force, sure));
    let own: Vec<Term> = terms.iter().enumerate().map(|(i, t)| (i, t.1)).collect();
    let w = blocks.fit(&own)?;
    let mut other = fit.clone();
    for (i, w) in w.iter().enumerate() {
        let strength = w * blocks.scale[i];
        match i.checked_sub(DECLARED) {
            None => other.parameters[i] = strength,
            Some(e) => other.elements[e].1 = strength,
        }
    }
    Some(other)
}

/// Steps of the search for a give, and how many of them.
const HALVINGS: usize = 40;

/// The give of the slider with which the model takes as much work as was measured, mm, with its 90 % interval: any law by
/// which friction builds up takes the work of one slider. `relative` is the standard error of the strength, of itself.
fn presliding(
    library: &Library,
    sliding: &Sliding,
    slider: usize,
    relative: f64,
) -> Option<(f64, [f64; 2])> {
    let fit = &sliding.fit;
    let mut left: Vec<f64> = library
        .tracks
        .iter()
        .flat_map(|t| t.force.clone())
        .collect();
    let mut take = |values: Vec<f64>, strength: f64| {
        crate::signals::add_scaled(&mut left, &values, -strength);
    };
    for i in 0..DECLARED {
        let of = |t: &Track| declared_columns(t)[i].clone();
        take(column(library.tracks, 1, of), fit.parameters[i]);
    }
    for (e, (element, strength)) in fit.elements.iter().enumerate() {
        if e != slider {
            let of = |t: &Track| element.force(t, &fit.sizes);
            take(column(library.tracks, 1, of), *strength);
        }
    }
    // Near a reversal; elsewhere it slides, whatever its give.
    let speed = column(library.tracks, 1, |t| {
        let near = near(&t.x, sliding.travel_mm);
        near.iter().zip(&t.v).map(|(near, v)| near * v).collect()
    });
    let force = fit.elements[slider].1;
    let law = fit.elements[slider].0.law;
    let slid = |yield_at: f64| {
        let element = Element::new(law, [yield_at]);
        column(library.tracks, 1, |t| element.force(t, &fit.sizes))
    };
    // Work that the measured force takes beyond the model's, sample by sample.
    let beyond = |yield_at: f64| -> Vec<f64> {
        let z = slid(yield_at);
        let all = left.iter().zip(&z).zip(&speed);
        all.map(|((f, z), v)| (f - force * z) * v).collect()
    };
    let sum = |yield_at: f64| beyond(yield_at).iter().sum::<f64>();
    let x = fit.sizes.x;
    let (mut low, mut high) = (1e-4 * x, 0.2 * x);
    // A longer give takes less.
    if force <= 0.0 || sum(low) > 0.0 || sum(high) < 0.0 {
        return None;
    }
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        if sum(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    let yield_at = (low * high).sqrt();
    let step = 0.05 * yield_at;
    let slope = (sum(yield_at + step) - sum(yield_at - step)) / (2.0 * step);
    let work = beyond(yield_at);
    let scatter = SANDWICH
        .iter()
        .map(|&blocks| {
            let block = work.len().div_ceil(blocks);
            let sums = work.chunks(block).map(|c| c.iter().sum::<f64>());
            sums.map(|s| s * s).sum::<f64>().sqrt()
        })
        .fold(0.0, f64::max);
    let by_force: f64 = slid(yield_at)
        .iter()
        .zip(&speed)
        .map(|(z, v)| force * relative * z * v)
        .sum();
    let error = scatter.hypot(by_force) / slope;
    let half = NINETY * error;
    // What the squares say of it is another reading: neither knows the law.
    let squares = fit.elements[slider].0.shape[0];
    let interval = [yield_at.min(squares) - half, yield_at.max(squares) + half];
    (slope > 0.0).then_some((yield_at, interval))
}
