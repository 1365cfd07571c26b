//! Estimates a row of the matrices from a record alone: instrumental variables, with a covariance from blocks.
//!
//! Least squares of the force on noisy readings would bias entries low, accelerations most. The target moved like the
//! specimen but without the readings' noise: as an instrument it averages the noise out.

use super::record::Moved;
use crate::model::coordinates::CoupledSpecimen;
use crate::record::refusal::Refusal;
use nalgebra::{DMatrix, DVector};

/// The unknowns of a row with their uncertainty.
pub struct Estimate {
    /// In the order of [`CoupledSpecimen::row`].
    pub value: DVector<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
}

/// Lengths of blocks, s: longer ones capture correlation that lasts longer than a block.
const BLOCKS_S: [f64; 3] = [0.25, 0.5, 1.0];
/// Avoids division by zero for what a motion cannot tell apart, as a fraction of a column's own squares.
const RIDGE: f64 = 1e-9;

/// One estimate for each coordinate.
pub fn estimate(declared: &CoupledSpecimen, train: &[Moved]) -> Result<Vec<Estimate>, Refusal> {
    let n = declared.count();
    // One additional unknown: the force at rest.
    let unknowns = 3 * n + 1;
    let size = |columns: fn(&Moved) -> &Vec<Vec<f64>>| -> Vec<f64> {
        let rms = |c: usize| {
            let all = train.iter().flat_map(|m| &columns(m)[c]);
            all.map(|x| x * x).sum::<f64>().sqrt()
        };
        let samples = train.iter().map(Moved::len).sum::<usize>() as f64;
        (0..3 * n).map(rms).chain([samples.sqrt()]).collect()
    };
    let (by, with) = (size(|m| &m.motion), size(|m| &m.instrument));
    if let Some(c) = with.iter().position(|s| s.is_nan() || *s <= 0.0) {
        return Err(Refusal::new(format!(
            "the target of {} stands still: accepted are records in which it moves",
            declared.coordinates[c % n]
        )));
    }
    let scaled = |columns: &[Vec<f64>], size: &[f64], k: usize| {
        DVector::from_fn(unknowns, |c, _| {
            columns.get(c).map_or(1.0, |x| x[k]) / size[c]
        })
    };
    let mut bread = DMatrix::<f64>::identity(unknowns, unknowns) * RIDGE;
    let mut seen = DMatrix::<f64>::zeros(unknowns, n);
    for m in train {
        for k in 0..m.len() {
            let (a, z) = (scaled(&m.motion, &by, k), scaled(&m.instrument, &with, k));
            bread.ger(1.0, &z, &a, 1.0);
            for (i, force) in m.force.iter().enumerate() {
                seen.column_mut(i).axpy(force[k], &z, 1.0);
            }
        }
    }
    let inverse = bread.try_inverse().ok_or_else(|| {
        Refusal::new(
            "the coordinates move as one: accepted are records in which they move by themselves",
        )
    })?;
    let solution = &inverse * seen;
    Ok((0..n)
        .map(|i| {
            let x = solution.column(i).into_owned();
            let left = |m: &Moved, k: usize| {
                let rest = m.force[i][k] - scaled(&m.motion, &by, k).dot(&x);
                (rest, scaled(&m.instrument, &with, k))
            };
            let scatter = BLOCKS_S
                .iter()
                .map(|seconds| scatter(train, *seconds, &inverse, left))
                .max_by(|a, b| a.trace().total_cmp(&b.trace()));
            let scatter = scatter.unwrap_or_else(|| DMatrix::zeros(unknowns, unknowns));
            Estimate {
                value: DVector::from_fn(3 * n, |c, _| x[c] / by[c]),
                covariance: DMatrix::from_fn(3 * n, 3 * n, |c, d| {
                    scatter[(c, d)] / (by[c] * by[d])
                }),
            }
        })
        .collect())
}

/// Covariance of the unknowns from the scatter between blocks; `left` gives what is left of a sample's force, and its
/// instrument.
fn scatter(
    train: &[Moved],
    block_s: f64,
    inverse: &DMatrix<f64>,
    left: impl Fn(&Moved, usize) -> (f64, DVector<f64>),
) -> DMatrix<f64> {
    let unknowns = inverse.nrows();
    let mut scores = Vec::new();
    let (mut squares, mut samples) = (0.0, 0.0);
    for m in train {
        let block = ((block_s / m.interval_s) as usize).max(4);
        for start in (0..m.len()).step_by(block) {
            let mut score = DVector::<f64>::zeros(unknowns);
            for k in start..(start + block).min(m.len()) {
                let (rest, instrument) = left(m, k);
                squares += rest * rest;
                samples += 1.0;
                score.axpy(rest, &instrument, 1.0);
            }
            scores.push(score);
        }
    }
    let blocks = scores.len() as f64;
    let used = blocks / (blocks - unknowns as f64).max(0.5 * blocks);
    // Whatever only the ridge determines is unknown.
    let ridge = (RIDGE * squares / samples).sqrt();
    scores.extend(
        (0..unknowns).map(|u| DVector::from_fn(unknowns, |c, _| if c == u { ridge } else { 0.0 })),
    );
    // As a square: no rounding makes a variance negative.
    let turned = inverse * DMatrix::from_columns(&scores);
    &turned * turned.transpose() * used
}
