//! The unknowns of a fit: declared parameters, strengths and shapes of terms, with their bounds.

use super::row::unit;
use super::score::LEAVES_NOISE;
use super::search::DECLARED;
use super::specimen::{SpecimenData, SpecimenModelFit};
use crate::numbers::linear::{Bound, Factor, gram};
use crate::numbers::signals::difference_quotient;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Step for a slope, relative to the unknown or to its unit.
const STEP: f64 = 1e-3;

/// Number of segments whose pulls give the scatter of a fit, and further numbers: fewer capture longer correlations.
const SEGMENTS: usize = 24;
const MORE_SEGMENTS: [usize; 2] = [12, 48];

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

    /// A fit's response to its unknowns, as weighed; `None` without any, or if they cannot be told apart at all.
    pub fn linearised(&self, fit: &SpecimenModelFit, unknowns: &[Freedom]) -> Option<Linearised> {
        if unknowns.is_empty() {
            return None;
        }
        let (weights, residual) = self.weighed(fit);
        let root: Vec<f64> = weights.iter().map(|w| w.sqrt()).collect();
        let columns = self.slopes_of(fit, unknowns);
        let columns: Vec<Vec<f64>> = columns.iter().map(|c| product(c, &root)).collect();
        Some(Linearised {
            factor: Factor::of(gram(&columns))?,
            residual: product(&residual, &root),
            columns,
            root,
            leaves_noise: fit.evidence.left_rms() < LEAVES_NOISE,
        })
    }

    /// How far the unknowns have been shifted by the noise of the displacement. At a reversal noise goes further than the
    /// motion, and so widens every gap; it does not average out. As much as the fit would move at twice this noise.
    pub fn shift(&self, fit: &SpecimenModelFit, at: &Linearised) -> DVector<f64> {
        let here = self.answered(fit);
        let [up, down] = self.answered_at_twice_the_noise(fit);
        let more = up.iter().zip(&down).zip(&here);
        // Both signs: what is proportional to the noise is in the scatter already.
        let change: Vec<f64> = more.map(|((a, b), h)| 0.5 * (a + b) - h).collect();
        -at.step(&change)
    }
}

/// A fit's response to small changes of its unknowns.
#[derive(Debug)]
pub struct Linearised {
    columns: Vec<Vec<f64>>,
    factor: Factor,
    residual: Vec<f64>,
    /// The roots of the samples' weights.
    root: Vec<f64>,
    leaves_noise: bool,
}

impl Linearised {
    /// Step of the unknowns for a change of the data.
    fn step(&self, change: &[f64]) -> DVector<f64> {
        let change = product(change, &self.root);
        self.factor.regression(&self.columns, &change).into()
    }

    /// Covariance of the unknowns, from how far segments of the record pull the fit apart.
    pub fn covariance(&self) -> DMatrix<f64> {
        let n = self.columns.len();
        let pulls_of = |segments: usize| self.factor.pulls(&self.columns, &self.residual, segments);
        let pulls = pulls_of(SEGMENTS);
        let mut most = pulls.diagonal();
        for segments in MORE_SEGMENTS {
            most = most.sup(&pulls_of(segments).diagonal());
        }
        // At least that of the noise alone: a few segments can agree by chance.
        let least = if self.leaves_noise { 1.0 } else { 0.0 };
        // Rows and columns scale together, so that what cannot be told apart stays so.
        let grow = |i: usize| {
            let own = pulls[(i, i)].max(LEAST_PULL * least);
            (most[i].max(least) / own.max(f64::MIN_POSITIVE)).sqrt()
        };
        let grow = DVector::from_fn(n, |i, _| grow(i));
        let pulls = DMatrix::from_fn(n, n, |i, j| pulls[(i, j)] * grow[i] * grow[j]);
        self.factor.covariance(&pulls, SEGMENTS)
    }
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a * b).collect()
}
