//! Scalar products of all columns, block by block of the training data: enough to fit any model, and to judge it on the
//! block left out, without the data.

use super::score::{BLOCKS, Score};
use crate::numbers::bounded::Equations;
use crate::numbers::linear::{Bound, dot};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Products over one block's samples.
#[derive(Clone, Debug)]
struct Block {
    gram: DMatrix<f64>,
    right: DVector<f64>,
    square: f64,
}

/// Products of all blocks, for columns scaled to a mean square of 1.
#[derive(Clone, Debug)]
pub struct Grams {
    each: Vec<Block>,
    scale: Vec<f64>,
}

/// A fitted model: its strengths, and its residual on each left-out block.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// Strengths in the columns' own units.
    pub strengths: Vec<f64>,
    /// Residual squares on each block, fitted to the other eleven.
    pub left_out: [f64; BLOCKS],
    /// Residual squares on each block, fitted to all.
    pub left: [f64; BLOCKS],
}

impl Grams {
    /// From columns and a target; `edges` are the blocks' first samples and the end.
    pub fn new(columns: &[Vec<f64>], target: &[f64], edges: &[usize]) -> Self {
        let scale: Vec<f64> = columns
            .par_iter()
            .map(|c| {
                let square = dot(c, c) / target.len() as f64;
                if square > 1e-280 && square.is_finite() {
                    square.sqrt().recip()
                } else {
                    0.0
                }
            })
            .collect();
        let each = edges
            .par_windows(2)
            .map(|e| block(columns, &scale, target, e[0], e[1]))
            .collect();
        Self { each, scale }
    }

    /// Products of some of the columns on one block, scaled.
    fn part(&self, block: &Block, at: &[usize]) -> Equations {
        let n = at.len();
        let mut part = Equations::zero(n);
        for (i, &row) in at.iter().enumerate() {
            for (j, &column) in at.iter().enumerate() {
                part.gram[i * n + j] = block.gram[(row, column)];
            }
            part.right[i] = block.right[row];
        }
        part.square = block.square;
        part
    }

    /// Fits a model with the score's own weights, which depend on the fit and are therefore computed twice, and judges
    /// it on each left-out block.
    pub fn fit(
        &self,
        terms: &[(usize, Bound)],
        ties: &[Tie],
        score: &Score,
        first: &[f64; BLOCKS],
    ) -> Option<Fitted> {
        let at: Vec<usize> = terms.iter().map(|t| t.0).collect();
        let parts: Vec<Equations> = self.each.iter().map(|b| self.part(b, &at)).collect();
        let by = |i: usize| self.scale[at[i]];
        let limit = |i: usize, x: f64| if by(i) > 0.0 { x / by(i) } else { 0.0 };
        let bounds = terms.iter().enumerate().map(|(i, (_, bound))| Bound {
            low: limit(i, bound.low),
            high: limit(i, bound.high),
        });
        let bounds: Vec<Bound> = bounds.collect();
        let scaled = ties.iter().map(|t| Tie {
            value: limit(t.unknown, t.value),
            weight: t.weight * by(t.unknown).powi(2),
            ..*t
        });
        let scaled: Vec<Tie> = scaled.collect();
        let mut fitted = judged(&parts, &bounds, &scaled, score, first)?;
        for (i, s) in fitted.strengths.iter_mut().enumerate() {
            *s *= by(i);
        }
        Some(fitted)
    }
}

/// A declared parameter held by its tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Tie {
    /// Index of the unknown.
    pub unknown: usize,
    /// The declared value.
    pub value: f64,
    /// Weight of its deviation from that value: [`Score::tie`].
    pub weight: f64,
}

/// Number of rounds of weights.
const ROUNDS: usize = 2;

/// Weighted least-squares values within bounds, and the residuals of each block by values fitted to the others.
pub fn judged(
    parts: &[Equations],
    bounds: &[Bound],
    ties: &[Tie],
    score: &Score,
    first: &[f64; BLOCKS],
) -> Option<Fitted> {
    let mut weights = *first;
    let mut strengths = Vec::new();
    let mut left = [0.0; BLOCKS];
    let summed = |weights: &[f64; BLOCKS]| {
        let mut sum = Equations::zero(bounds.len());
        for (part, weight) in parts.iter().zip(weights) {
            sum.add(part, *weight);
        }
        for tie in ties {
            sum.pull(tie.unknown, tie.value, tie.weight);
        }
        sum
    };
    for _ in 0..ROUNDS {
        let whole = summed(&weights);
        strengths = whole.solve(bounds)?;
        left = std::array::from_fn(|b| parts[b].left(&strengths));
        if strengths.iter().any(|s| !s.is_finite()) {
            return None;
        }
        weights = score.weights(&left);
    }
    let mut left_out = [0.0; BLOCKS];
    let whole = summed(&weights);
    for b in 0..BLOCKS {
        let mut others = whole.clone();
        others.add(&parts[b], -weights[b]);
        let values = others.solve(bounds)?;
        left_out[b] = parts[b].left(&values);
    }
    left_out.iter().all(|x| x.is_finite()).then_some(Fitted {
        strengths,
        left_out,
        left,
    })
}

fn block(columns: &[Vec<f64>], scale: &[f64], target: &[f64], a: usize, b: usize) -> Block {
    let across = DMatrix::from_fn(b - a, columns.len(), |i, j| columns[j][a + i] * scale[j]);
    let along = across.transpose();
    let y = DVector::from_column_slice(&target[a..b]);
    Block {
        gram: &along * across,
        right: along * &y,
        square: y.dot(&y),
    }
}
