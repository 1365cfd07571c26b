//! The unknowns of a fit: declared parameters, strengths and shapes of terms, with their bounds.

use super::row::unit;
use super::score::LEAVES_NOISE;
use super::search::DECLARED;
use super::specimen::{SpecimenData, SpecimenModelFit};
use crate::numbers::linear::{Bound, dot};
use crate::numbers::signals::difference_quotient;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Step for a slope, relative to the unknown or to its unit.
const STEP: f64 = 1e-3;

/// Number of segments whose pulls give the scatter of a fit.
const SEGMENTS: usize = 24;

/// Least pull of segments relative to that of noise: the pull of samples left out is zero, and must not be scaled up.
const LEAST_PULL: f64 = 0.1;

/// An unknown of a fit.
#[derive(Clone, Copy, Debug)]
pub enum Unknown {
    /// A declared parameter.
    Declared(usize),
    /// A strength of a term: term and index.
    Strength(usize, usize),
    /// A shape of a term: term and index.
    Shape(usize, usize),
}

/// An unknown with its bounds; a shape's limits are checked by its law.
#[derive(Clone, Copy, Debug)]
pub struct Freedom {
    /// The unknown.
    pub unknown: Unknown,
    /// Its bounds.
    pub bound: Bound,
    /// Its unit of measure.
    pub unit: f64,
}

impl Freedom {
    /// A fit with this unknown moved by one step, and the step.
    pub fn moved(&self, fit: &SpecimenModelFit) -> (SpecimenModelFit, f64) {
        let mut other = fit.clone();
        let step = STEP * self.unit;
        *self.place(&mut other) += step;
        (other, step)
    }

    /// Its place in a fit.
    pub fn place<'a>(&self, fit: &'a mut SpecimenModelFit) -> &'a mut f64 {
        match self.unknown {
            Unknown::Declared(i) => &mut fit.declared[i],
            Unknown::Strength(t, k) => &mut fit.strengths[t][k],
            Unknown::Shape(t, which) => &mut fit.terms[t].shape[which],
        }
    }

    /// Its value in a fit.
    pub fn value(&self, fit: &SpecimenModelFit) -> f64 {
        match self.unknown {
            Unknown::Declared(i) => fit.declared[i],
            Unknown::Strength(t, k) => fit.strengths[t][k],
            Unknown::Shape(t, which) => fit.terms[t].shape[which],
        }
    }

    /// True if its value in a fit is inside its bounds, not at a limit.
    pub fn is_inside(&self, fit: &SpecimenModelFit) -> bool {
        let (b, value) = (self.bound, self.value(fit));
        let room = 1e-6 * (b.high - b.low).min(value.abs());
        value > b.low + room && value < b.high - room
    }
}

impl SpecimenData<'_> {
    /// All unknowns of a fit.
    pub fn freedoms(&self, fit: &SpecimenModelFit) -> Vec<Freedom> {
        let bounds = self.bounds(&fit.terms);
        let of = |unknown: Unknown, bound: Bound, value: f64| Freedom {
            unknown,
            bound,
            unit: value.abs().max(1e-3),
        };
        let mut all: Vec<Freedom> = (0..DECLARED)
            .map(|i| of(Unknown::Declared(i), bounds[i], fit.declared[i]))
            .collect();
        let mut at = DECLARED;
        for (t, (term, strengths)) in fit.terms.iter().zip(&fit.strengths).enumerate() {
            for (k, s) in strengths.iter().enumerate() {
                // What acts once does so exactly: the search only varies it a little, for speed.
                if *s != 0.0 && !bounds[at + k].is_once() {
                    all.push(of(Unknown::Strength(t, k), bounds[at + k], *s));
                }
            }
            at += strengths.len();
            for (which, log, range) in self.rows[term.row].movable(term.shape, &self.sizes) {
                let unit = unit(log, term.shape[which], range);
                all.push(Freedom {
                    unknown: Unknown::Shape(t, which),
                    bound: Bound::FREE,
                    unit: unit.max(1e-9),
                });
            }
        }
        all
    }

    /// Change of the response to the training data with each unknown, per own unit.
    pub fn slopes_of(&self, fit: &SpecimenModelFit, freedoms: &[Freedom]) -> Vec<Vec<f64>> {
        let here = self.answered(fit);
        let slope = |f: &Freedom| {
            let (moved, step) = f.moved(fit);
            difference_quotient(&self.answered(&moved), &here, step)
        };
        freedoms.par_iter().map(slope).collect()
    }

    /// Covariance of the unknowns, from how far segments of the record pull the fit apart.
    pub fn covariance(&self, fit: &SpecimenModelFit, unknowns: &[Freedom]) -> Option<DMatrix<f64>> {
        let n = unknowns.len();
        if n == 0 {
            return None;
        }
        let (weights, residual) = self.weighed(fit);
        let root = |c: &[f64]| -> Vec<f64> {
            let own = c.iter().zip(&weights);
            own.map(|(x, w)| x * w.sqrt()).collect()
        };
        let residual = root(&residual);
        let columns = self.slopes_of(fit, unknowns);
        let columns: Vec<Vec<f64>> = columns.iter().map(|c| root(c)).collect();
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
        if fit.evidence.left_rms() < LEAVES_NOISE {
            // At least that of the noise alone: a few segments can agree by chance. Rows and columns scale together, so
            // that what cannot be told apart stays so.
            let grow = |i: usize| pulls[(i, i)].clamp(LEAST_PULL, 1.0).sqrt().recip();
            let grow = DVector::from_fn(n, |i, _| grow(i));
            pulls = DMatrix::from_fn(n, n, |i, j| pulls[(i, j)] * grow[i] * grow[j]);
        }
        let free = (SEGMENTS as f64 - n as f64).max(0.5 * SEGMENTS as f64);
        let all = &inverse * pulls * &inverse * (SEGMENTS as f64 / free);
        Some(DMatrix::from_fn(n, n, |i, j| {
            all[(i, j)] / size[i] / size[j]
        }))
    }
}
