//! Two coordinates act equally on each other: the theorem of Maxwell and Betti ties two entries to one unknown.
//!
//! There is no tie if the declaration itself has two values, or if the record contradicts it by more than a fraction of
//! the force: then the calibration of a force is wrong, not the specimen.

use super::fit::Estimate;
use super::record::Moved;
use crate::criteria::coordinates::{SHARE, SURE};
use crate::model::coordinates::{CoupledSpecimen, MATRICES};
use crate::model::declared::Declared;
use nalgebra::{DMatrix, DVector};

/// Position of an entry: its row, and its index among the row's unknowns.
pub type Place = (usize, usize);

/// The unknowns of all rows together.
pub struct Tied {
    /// Where each unknown appears: in one place or in two.
    pub places: Vec<Vec<Place>>,
    /// The declared values.
    pub declared: Vec<Declared>,
    /// The estimates from the record alone.
    pub estimate: Estimate,
    /// Pairs that the record contradicts.
    pub uneven: Vec<[Place; 2]>,
}

/// Fraction of a variance that may be rounding.
const ROUNDING: f64 = 1e-9;

/// Updates two unknowns as if their difference had been measured to be zero.
fn as_if_equal(a: usize, b: usize, value: &mut DVector<f64>, covariance: &mut DMatrix<f64>) {
    let turn = covariance.column(a) - covariance.column(b);
    let spread = turn[a] - turn[b];
    if spread > 0.0 {
        let gain = &turn / spread;
        let off = value[a] - value[b];
        value.axpy(-off, &gain, 1.0);
        covariance.ger(-1.0, &gain, &turn, 1.0);
    }
}

/// Ties the entries of `rows`.
pub fn tie(specimen: &CoupledSpecimen, rows: &[Estimate], train: &[Moved]) -> Tied {
    let n = specimen.count();
    let width = MATRICES.len() * n;
    let at = |(row, k): Place| row * width + k;
    let mut value = DVector::from_fn(n * width, |i, _| rows[i / width].value[i % width]);
    let mut covariance = DMatrix::from_fn(n * width, n * width, |i, j| {
        if i / width == j / width {
            rows[i / width].covariance[(i % width, j % width)]
        } else {
            0.0
        }
    });
    let apart = covariance.diagonal();
    let size: Vec<f64> = (0..width)
        .map(|k| {
            let all = train.iter().flat_map(|m| &m.motion[k]);
            let samples = train.iter().map(Moved::len).sum::<usize>() as f64;
            (all.map(|x| x * x).sum::<f64>() / samples).sqrt()
        })
        .collect();
    let largest = |row: usize| {
        let term = |k: usize| rows[row].value[k].abs() * size[k];
        (0..width).map(term).fold(0.0, f64::max)
    };
    let declared = |(row, k): Place| specimen.row(row)[k];
    let mut tied = Vec::new();
    let mut uneven = Vec::new();
    for (which, i) in (0..MATRICES.len()).flat_map(|which| (0..n).map(move |i| (which, i))) {
        for j in 0..i {
            let (a, b): (Place, Place) = ((j, which * n + i), (i, which * n + j));
            if declared(a) != declared(b) {
                continue;
            }
            let off = value[at(a)] - value[at(b)];
            let spread = covariance[(at(a), at(a))] + covariance[(at(b), at(b))];
            let share =
                (off.abs() * size[a.1] / largest(j)).min(off.abs() * size[b.1] / largest(i));
            if off * off > SURE * SURE * spread && share > SHARE {
                uneven.push([a, b]);
            } else {
                tied.push([a, b]);
            }
        }
    }
    for [a, b] in &tied {
        as_if_equal(at(*a), at(*b), &mut value, &mut covariance);
    }
    // These are differences of large numbers: their possible error is not certainty.
    for (i, own) in apart.iter().enumerate() {
        covariance[(i, i)] += ROUNDING * own;
    }
    let second = |place: Place| tied.iter().any(|[_, b]| *b == place);
    let first: Vec<Place> = (0..n)
        .flat_map(|row| (0..width).map(move |k| (row, k)))
        .filter(|place| !second(*place))
        .collect();
    Tied {
        estimate: Estimate {
            value: DVector::from_fn(first.len(), |c, _| value[at(first[c])]),
            covariance: DMatrix::from_fn(first.len(), first.len(), |c, d| {
                covariance[(at(first[c]), at(first[d]))]
            }),
        },
        declared: first.iter().map(|place| declared(*place)).collect(),
        places: first
            .into_iter()
            .map(|place| {
                let other = tied.iter().find(|[a, _]| *a == place);
                std::iter::once(place)
                    .chain(other.map(|[_, b]| *b))
                    .collect()
            })
            .collect(),
        uneven,
    }
}
