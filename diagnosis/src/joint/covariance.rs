//! How the unknowns of a fit vary together.

use super::fit::SpecimenFit;
use super::set::{DECLARED, Library, column};
use crate::linear::{Bound, dot};
use crate::signals::{add_scaled, difference, difference_quotient};
use nalgebra::{DMatrix, DVector};

/// Blocks of the sandwich, from long to short: what is correlated over many samples shows in the long ones.
pub const SANDWICH: [usize; 3] = [12, 40, 120];
/// Step of a shape, relative, and of a strength.
const STEP: f64 = 1e-3;
/// Below this share of a column's squares a direction is not told by the record.
const UNTOLD: f64 = 1e-6;

/// An unknown of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FitUnknown {
    /// A declared parameter.
    Parameter(usize),
    /// The strength of an element.
    Strength(usize),
    /// A shape of an element.
    Shape(usize, usize),
}

impl FitUnknown {
    /// The fit with this unknown moved, and by how much.
    pub fn moved(self, fit: &SpecimenFit) -> (SpecimenFit, f64) {
        let mut other = fit.clone();
        let step = STEP * self.place(&mut other).abs().max(1e-6);
        self.add(&mut other, step);
        (other, step)
    }

    /// Moves it by a step.
    fn add(self, fit: &mut SpecimenFit, step: f64) {
        *self.place(fit) += step;
    }

    fn place(self, fit: &mut SpecimenFit) -> &mut f64 {
        match self {
            Self::Parameter(i) => &mut fit.parameters[i],
            Self::Strength(i) => &mut fit.elements[i].1,
            Self::Shape(i, at) => &mut fit.elements[i].0.shape[at],
        }
    }
}

/// Parameters inside their bounds, strengths, shapes that can be moved.
pub fn unknowns(library: &Library, fit: &SpecimenFit) -> Vec<FitUnknown> {
    let inside = |&i: &usize| {
        let bound = library.parameter(i, fit.moved[i]);
        let value = fit.parameters[i];
        // A parameter that has left its tolerance has no upper bound.
        let room = 1e-6 * (bound.high - bound.low).min(value.abs());
        value > bound.low + room && value < bound.high - room
    };
    let mut all: Vec<FitUnknown> = (0..DECLARED)
        .filter(inside)
        .map(FitUnknown::Parameter)
        .collect();
    for (i, (element, strength)) in fit.elements.iter().enumerate() {
        if *strength == 0.0 {
            continue;
        }
        all.push(FitUnknown::Strength(i));
        let shapes = element.movable().iter();
        all.extend(shapes.map(|(at, _)| FitUnknown::Shape(i, *at)));
    }
    all
}

/// Samples that are in a choice.
pub fn chosen(x: &[f64], choice: &[bool]) -> Vec<f64> {
    let pairs = x.iter().zip(choice);
    pairs.filter(|(_, own)| **own).map(|(x, _)| *x).collect()
}

/// What a fit answers to the data of a library.
fn answer(library: &Library, fit: &SpecimenFit) -> Vec<f64> {
    let mut y = vec![0.0; library.force.len()];
    for i in 0..DECLARED {
        add_scaled(&mut y, &library.columns[i], fit.parameters[i]);
    }
    for (element, strength) in &fit.elements {
        let force = column(library.tracks, library.every, |t| {
            element.force(t, &fit.sizes)
        });
        add_scaled(&mut y, &force, *strength);
    }
    y
}

/// Measured less answered.
fn residual(library: &Library, fit: &SpecimenFit) -> Vec<f64> {
    difference(&library.force, &answer(library, fit))
}

/// A fit made linear: what it leaves, and how its answer changes with its unknowns; over all samples or those of a choice.
struct Linear {
    residual: Vec<f64>,
    columns: Vec<Vec<f64>>,
    /// Norm of each column; what the choice does not tell at all has none.
    size: Vec<f64>,
    /// Inverse of the columns' products, of columns scaled to 1.
    inverse: DMatrix<f64>,
}

impl Linear {
    fn of(
        library: &Library,
        fit: &SpecimenFit,
        unknowns: &[FitUnknown],
        choice: Option<&[bool]>,
    ) -> Self {
        let here = answer(library, fit);
        let of = |all: Vec<f64>| choice.map_or_else(|| all.clone(), |own| chosen(&all, own));
        let residual = of(difference(&library.force, &here));
        let columns: Vec<Vec<f64>> = unknowns
            .iter()
            .map(|unknown| {
                let (moved, step) = unknown.moved(fit);
                let there = answer(library, &moved);
                of(difference_quotient(&there, &here, step))
            })
            .collect();
        let n = columns.len();
        let size: Vec<f64> = columns
            .iter()
            .map(|c| dot(c, c).sqrt())
            // What the choice does not tell at all does not vary.
            .map(|norm| if norm > 0.0 { norm.recip() } else { 0.0 })
            .collect();
        let bread = DMatrix::from_fn(n, n, |i, j| {
            dot(&columns[i], &columns[j]) * size[i] * size[j]
        });
        // Directions that the record does not tell at all stay where they are.
        let eigen = bread.symmetric_eigen();
        let inverses = eigen
            .eigenvalues
            .map(|l| if l > UNTOLD { 1.0 / l } else { 0.0 });
        let q = &eigen.eigenvectors;
        let inverse = q * DMatrix::from_diagonal(&inverses) * q.transpose();
        Self {
            residual,
            columns,
            size,
            inverse,
        }
    }
}

/// How the unknowns of a fit vary together: `H^-1 (sum of outer products of the blocks' scores) H^-1`, over all samples or those
/// of a choice. It holds for what is left in any colour, and where the model is not exact.
pub fn covariance(
    library: &Library,
    fit: &SpecimenFit,
    unknowns: &[FitUnknown],
    choice: Option<&[bool]>,
) -> Option<DMatrix<f64>> {
    if unknowns.is_empty() {
        return None;
    }
    let Linear {
        residual,
        columns,
        size,
        inverse,
    } = Linear::of(library, fit, unknowns, choice);
    let n = columns.len();
    let samples = residual.len();
    // The widest of several block lengths.
    let widest = SANDWICH
        .iter()
        .filter(|&&blocks| samples >= 4 * blocks)
        .map(|&blocks| {
            let mut meat: DMatrix<f64> = DMatrix::zeros(n, n);
            for b in 0..blocks {
                let (a, e) = (b * samples / blocks, (b + 1) * samples / blocks);
                let score =
                    DVector::from_fn(n, |i, _| dot(&columns[i][a..e], &residual[a..e]) * size[i]);
                meat += &score * score.transpose();
            }
            // What was fitted has taken its share of the scatter.
            let free = blocks as f64 / (blocks as f64 - n as f64).max(0.5 * blocks as f64);
            &inverse * meat * &inverse * free
        })
        .max_by(|a, b| a.trace().total_cmp(&b.trace()))?;
    Some(DMatrix::from_fn(n, n, |i, j| {
        widest[(i, j)] * size[i] * size[j]
    }))
}

/// Steps towards the least squares, and halvings of each at most.
const STEPS: usize = 4;
const HALVINGS: i32 = 4;

/// The same fit, its unknowns moved together to the least squares: shapes that were searched one after the other on a grid are
/// some percent off theirs, which no interval knows.
pub fn settled(library: &Library, fit: &SpecimenFit) -> SpecimenFit {
    let mut best = fit.clone();
    let all = unknowns(library, fit);
    if all.is_empty() {
        return best;
    }
    let squares = |residual: &[f64]| dot(residual, residual);
    for _ in 0..STEPS {
        let here = Linear::of(library, &best, &all, None);
        let left = squares(&here.residual);
        let right = DVector::from_fn(all.len(), |i, _| {
            dot(&here.columns[i], &here.residual) * here.size[i]
        });
        let step = &here.inverse * right;
        let moved = |halvings: i32| {
            let mut other = best.clone();
            for (i, unknown) in all.iter().enumerate() {
                unknown.add(&mut other, 0.5_f64.powi(halvings) * step[i] * here.size[i]);
            }
            let lower = is_possible(library, &other) && squares(&residual(library, &other)) < left;
            lower.then_some(other)
        };
        let Some(better) = (0..HALVINGS).find_map(moved) else {
            break;
        };
        best = better;
    }
    best
}

/// Whether parameters and strengths are within their bounds and shapes can be those of their laws.
fn is_possible(library: &Library, fit: &SpecimenFit) -> bool {
    let within = |bound: Bound, value: f64| (bound.low..=bound.high).contains(&value);
    let mut parameters = fit.parameters.iter().enumerate();
    let mut elements = fit.elements.iter();
    parameters.all(|(i, value)| within(library.parameter(i, fit.moved[i]), *value))
        && elements.all(|(e, strength)| within(e.bound(), *strength) && e.is_sound(&fit.sizes))
}
