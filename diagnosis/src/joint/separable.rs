//! What the motion itself can tell apart: how much of an element's force the best element of another kind would leave.

use super::blocks::Term;
use super::kind::ElementKind;
use super::set::{DECLARED, ElementSet, Library};
use crate::criteria::INSEPARABLE;
use crate::linear::{Bound, dot};
use plant::Effect;
use rayon::prelude::*;

/// Names of other kinds whose force over this motion differs from that of some elements of a set by so little that no
/// fit could see it above what the set leaves. This depends on the motion and the size of the force, not on which fits.
pub fn inseparable(
    library: &Library,
    set: &ElementSet,
    kind: ElementKind,
    own: &[usize],
) -> Vec<(Effect, ElementKind)> {
    let Some(w) = library.blocks.fit(&library.terms(set)) else {
        return Vec::new();
    };
    let (level, samples) = rest(library, set, &w);
    // The elements' force as the thing to be fitted.
    let mut target = library.blocks.all.clone();
    target.right.fill(0.0);
    target.square = 0.0;
    let mut parts = Vec::new();
    for (&e, strength) in set.elements.iter().zip(&w[DECLARED..]) {
        if own.contains(&e) {
            parts.push((DECLARED + e, *strength));
        }
    }
    for &(i, a) in &parts {
        target.right += library.blocks.all.gram.column(i) * a;
        for &(j, b) in &parts {
            target.square += a * b * library.blocks.all.gram[(i, j)];
        }
    }
    let declared: Vec<Term> = (0..DECLARED)
        .map(|i| {
            let bound = library.parameter(i, set.moved[i]);
            let here = w[i] * library.blocks.scale[i];
            let shifted = Bound {
                low: bound.low - here,
                high: bound.high - here,
            };
            (i, shifted)
        })
        .collect();
    let left = |e: usize| -> Option<f64> {
        let mut terms = declared.clone();
        terms.push((DECLARED + e, library.elements[e].bound()));
        let w = library.blocks.fit_to(&target, &terms)?;
        let at: Vec<usize> = terms.iter().map(|t| t.0).collect();
        Some(target.cost(&at, &w) / library.force.len() as f64)
    };
    let others = (0..library.elements.len()).filter(|&e| {
        let element = &library.elements[e];
        element.kind(&library.sizes) != kind && !element.is_nearly(kind, &library.sizes)
    });
    let others: Vec<usize> = others.collect();
    let mut close: Vec<(Effect, ElementKind, f64)> = others
        .par_iter()
        .filter_map(|&e| {
            let j = samples * left(e)? / level;
            let element = &library.elements[e];
            let name = element.name(&library.sizes, 1.0);
            (j < INSEPARABLE).then_some((name, element.kind(&library.sizes), j))
        })
        .collect();
    close.sort_by(|a, b| a.2.total_cmp(&b.2));
    let mut names: Vec<(Effect, ElementKind)> = Vec::new();
    for (name, kind, _) in close {
        if names.iter().all(|n| n.1 != kind) {
            names.push((name, kind));
        }
    }
    names
}

/// Mean square of what a set leaves, and how many independent samples that is worth by its colour.
fn rest(library: &Library, set: &ElementSet, w: &[f64]) -> (f64, f64) {
    let mut residual = library.force.clone();
    for (term, w) in library.terms(set).iter().zip(w) {
        let by = -w * library.blocks.scale[term.0];
        crate::signals::add_scaled(&mut residual, &library.columns[term.0], by);
    }
    let n = residual.len();
    let square = dot(&residual, &residual).max(f64::MIN_POSITIVE);
    // Correlations up to where they first are none.
    let mut sum = 0.0;
    for lag in 1..n / 10 {
        let c = dot(&residual[lag..], &residual[..n - lag]) / square;
        if c <= 0.0 {
            break;
        }
        sum += c;
    }
    (square / n as f64, n as f64 / (1.0 + 2.0 * sum))
}
