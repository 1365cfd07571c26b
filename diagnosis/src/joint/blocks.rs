//! Scalar products of all columns with each other, block by block of the data: with them the cost of any model on any
//! block, fitted to all data or to all but that block, needs no data any more.

use crate::criteria::BLOCKS;
use crate::linear::{Bound, dot};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// The largest model, declared parameters and elements together.
pub const MOST: usize = 16;

/// Scalar products of one block, or of all.
#[derive(Clone, Debug)]
pub struct Products {
    /// Of columns with columns.
    pub gram: DMatrix<f64>,
    /// Of columns with the measured force.
    pub right: DVector<f64>,
    /// Of the force with itself.
    pub square: f64,
}

/// All columns, scaled to a mean square of 1.
#[derive(Clone, Debug)]
pub struct Blocks {
    /// One for each block.
    pub each: Vec<Products>,
    /// Their sum.
    pub all: Products,
    /// What each column was multiplied by.
    pub scale: Vec<f64>,
    /// Samples in each block.
    pub samples: Vec<f64>,
}

/// A column of a model and what its strength may be, in the columns' own unit.
pub type Term = (usize, Bound);

impl Products {
    fn less(&self, other: &Self) -> Self {
        Self {
            gram: &self.gram - &other.gram,
            right: &self.right - &other.right,
            square: self.square - other.square,
        }
    }

    /// Squares that strengths leave; `at` are the columns.
    pub fn cost(&self, at: &[usize], w: &[f64]) -> f64 {
        let mut cost = self.square;
        for (i, &a) in at.iter().enumerate() {
            let mut row = 0.0;
            for (j, &b) in at[..i].iter().enumerate() {
                row += self.gram[(b, a)] * w[j];
            }
            cost += w[i] * (2.0 * row + self.gram[(a, a)] * w[i] - 2.0 * self.right[a]);
        }
        cost.max(0.0)
    }
}

impl Blocks {
    /// From columns and the measured force.
    pub fn new(columns: &[Vec<f64>], force: &[f64]) -> Self {
        let n = force.len();
        let scale = scales(columns, n);
        let edges: Vec<usize> = (0..=BLOCKS).map(|b| b * n / BLOCKS).collect();
        let each: Vec<Products> = edges
            .par_windows(2)
            .map(|e| products(columns, &scale, force, e[0], e[1]))
            .collect();
        Self {
            all: sum(&each),
            each,
            scale,
            samples: edges.windows(2).map(|e| (e[1] - e[0]) as f64).collect(),
        }
    }

    /// Products of the columns that were added since.
    pub fn grow(&mut self, columns: &[Vec<f64>], force: &[f64]) {
        let (old, n) = (self.scale.len(), force.len());
        self.scale.extend(scales(&columns[old..], n));
        let mut first = 0;
        for b in 0..BLOCKS {
            let end = first + self.samples[b] as usize;
            let p = &mut self.each[b];
            p.gram.resize_mut(columns.len(), columns.len(), 0.0);
            let more = columns.len() - old;
            p.right.resize_vertically_mut(old + more, 0.0);
            for i in old..columns.len() {
                let c = &columns[i][first..end];
                for j in 0..=i {
                    let g = dot(c, &columns[j][first..end]) * self.scale[i] * self.scale[j];
                    p.gram[(i, j)] = g;
                    p.gram[(j, i)] = g;
                }
                p.right[i] = dot(c, &force[first..end]) * self.scale[i];
            }
            first = end;
        }
        self.all = sum(&self.each);
    }

    /// Strengths of a model, fitted to all data.
    pub fn fit(&self, terms: &[Term]) -> Option<Vec<f64>> {
        solve(&self.all, terms, &self.scale)
    }

    /// Strengths of a model that is fitted to another force, whose products with all columns are given.
    pub fn fit_to(&self, target: &Products, terms: &[Term]) -> Option<Vec<f64>> {
        solve(target, terms, &self.scale)
    }

    /// Squares on each block of a model that was fitted to all data.
    pub fn trained(&self, terms: &[Term]) -> Option<[f64; BLOCKS]> {
        let w = self.fit(terms)?;
        let at = columns_of(terms);
        Some(std::array::from_fn(|b| self.each[b].cost(&at, &w)))
    }

    /// Squares on each block of a model that was fitted to all others.
    pub fn cross_validated(&self, terms: &[Term]) -> Option<[f64; BLOCKS]> {
        let at = columns_of(terms);
        let mut costs = [0.0; BLOCKS];
        let small = self.of(&at);
        let here: Vec<Term> = terms.iter().enumerate().map(|(i, t)| (i, t.1)).collect();
        let places: Vec<usize> = (0..at.len()).collect();
        for (b, cost) in costs.iter_mut().enumerate() {
            let others = small.all.less(&small.each[b]);
            let w = solve(&others, &here, &small.scale)?;
            *cost = small.each[b].cost(&places, &w);
        }
        Some(costs)
    }

    /// Squares on each block of all columns, fitted to all others with a ridge on each column's own square; not within bounds.
    pub fn ridge_cross_validated(&self, ridge: impl Fn(usize, f64) -> f64) -> Option<Vec<f64>> {
        let n = self.scale.len();
        let cost = |p: &Products| {
            let mut others = self.all.less(p);
            for i in 0..n {
                others.gram[(i, i)] += ridge(i, self.all.gram[(i, i)]);
            }
            let w = others.gram.cholesky()?.solve(&others.right);
            Some(p.square - 2.0 * w.dot(&p.right) + w.dot(&(&p.gram * &w)))
        };
        self.each.iter().map(cost).collect()
    }

    /// Some of the columns only.
    pub fn of(&self, at: &[usize]) -> Self {
        let part = |p: &Products| Products {
            gram: DMatrix::from_fn(at.len(), at.len(), |i, j| p.gram[(at[i], at[j])]),
            right: DVector::from_fn(at.len(), |i, _| p.right[at[i]]),
            square: p.square,
        };
        Self {
            each: self.each.iter().map(part).collect(),
            all: part(&self.all),
            scale: at.iter().map(|a| self.scale[*a]).collect(),
            samples: self.samples.clone(),
        }
    }
}

fn scales(columns: &[Vec<f64>], n: usize) -> Vec<f64> {
    let scale = |c: &Vec<f64>| {
        let square = dot(c, c) / n as f64;
        if square > 1e-280 {
            square.sqrt().recip()
        } else {
            0.0
        }
    };
    columns.par_iter().map(scale).collect()
}

fn sum(each: &[Products]) -> Products {
    let mut all = each[0].clone();
    for p in &each[1..] {
        all.gram += &p.gram;
        all.right += &p.right;
        all.square += p.square;
    }
    all
}

fn columns_of(terms: &[Term]) -> Vec<usize> {
    terms.iter().map(|t| t.0).collect()
}

fn products(columns: &[Vec<f64>], scale: &[f64], force: &[f64], a: usize, b: usize) -> Products {
    let across = DMatrix::from_fn(b - a, columns.len(), |i, j| columns[j][a + i] * scale[j]);
    let along = across.transpose();
    let f = DVector::from_column_slice(&force[a..b]);
    Products {
        gram: &along * across,
        right: along * &f,
        square: f.dot(&f),
    }
}

/// Ridge, relative to each column's own square: columns that are one and the same share their strength.
const RIDGE: f64 = 1e-10;

/// Least squares within bounds, by an active set: small and quick, since it is asked a million times.
/// Strengths are those of the scaled columns, bounds those of the columns as they are.
fn solve(p: &Products, terms: &[Term], scale: &[f64]) -> Option<Vec<f64>> {
    let n = terms.len();
    debug_assert!(n <= MOST);
    let mut w = [0.0; MOST];
    let (mut low, mut high) = ([0.0; MOST], [0.0; MOST]);
    let mut free = [true; MOST];
    for (i, (column, bound)) in terms.iter().enumerate() {
        let by = scale[*column];
        if by == 0.0 {
            free[i] = false;
            continue;
        }
        (low[i], high[i]) = (bound.low / by, bound.high / by);
        if low[i] >= high[i] {
            free[i] = false;
            w[i] = low[i];
        }
    }
    for _ in 0..3 * n + 1 {
        let mut at = [0; MOST];
        let mut m = 0;
        for i in (0..n).filter(|i| free[*i]) {
            at[m] = i;
            m += 1;
        }
        let mut l = [[0.0; MOST]; MOST];
        let mut y = [0.0; MOST];
        for i in 0..m {
            let row = terms[at[i]].0;
            let mut right = p.right[row];
            for k in (0..n).filter(|k| !free[*k] && w[*k] != 0.0) {
                right -= p.gram[(terms[k].0, row)] * w[k];
            }
            for j in 0..=i {
                let mut sum = p.gram[(terms[at[j]].0, row)];
                if i == j {
                    sum *= 1.0 + RIDGE;
                }
                for k in 0..j {
                    sum -= l[i][k] * l[j][k];
                }
                if i == j {
                    if sum <= 0.0 {
                        return None;
                    }
                    l[i][i] = sum.sqrt();
                } else {
                    l[i][j] = sum / l[j][j];
                }
            }
            for k in 0..i {
                right -= l[i][k] * y[k];
            }
            y[i] = right / l[i][i];
        }
        for i in (0..m).rev() {
            let mut sum = y[i];
            for k in i + 1..m {
                sum -= l[k][i] * w[at[k]];
            }
            w[at[i]] = sum / l[i][i];
        }
        let mut worst = (0.0, usize::MAX);
        for &i in &at[..m] {
            let out = (low[i] - w[i]).max(w[i] - high[i]);
            if out > worst.0 {
                worst = (out, i);
            }
        }
        if worst.1 < usize::MAX {
            let i = worst.1;
            w[i] = w[i].clamp(low[i], high[i]);
            free[i] = false;
            continue;
        }
        // What was fixed and would go back inside is free again.
        let mut inward = None;
        let mut best_fall = 1e-9 * p.square.max(0.0);
        for i in (0..n).filter(|&i| !free[i] && low[i] < high[i]) {
            let row = terms[i].0;
            let pulls = (0..n).map(|k| p.gram[(terms[k].0, row)] * w[k]);
            let slope = p.right[row] - pulls.sum::<f64>();
            let in_by = if w[i] <= low[i] { slope } else { -slope };
            // The squares fall by half of its square over the column's own.
            let fall = in_by.max(0.0).powi(2) / p.gram[(row, row)].max(f64::MIN_POSITIVE);
            if fall > best_fall {
                (best_fall, inward) = (fall, Some(i));
            }
        }
        let Some(i) = inward else {
            return Some(w[..n].to_vec());
        };
        free[i] = true;
    }
    Some(w[..n].to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_left_out_is_judged_by_the_others() {
        let n = 600;
        let ramp: Vec<f64> = (0..n).map(|i| i as f64).collect();
        let one = vec![1.0; n];
        // A line, but for the last block, which is 10 higher.
        let force: Vec<f64> = (0..n)
            .map(|i| 2.0 * i as f64 + 3.0 + if i >= 500 { 10.0 } else { 0.0 })
            .collect();
        let blocks = Blocks::new(&[ramp, one], &force);
        let free = [(0, Bound::FREE), (1, Bound::FREE)];
        let cv = blocks.cross_validated(&free).unwrap();
        assert!((cv[5] - 100.0 * 100.0).abs() < 1.0, "{cv:?}");
        // Within bounds: the slope is held, the rest makes the best of it.
        let held = Bound {
            low: 0.0,
            high: 1.0,
        };
        let w = blocks.fit(&[(0, held), (1, Bound::FREE)]).unwrap();
        assert!((w[0] * blocks.scale[0] - 1.0).abs() < 1e-9, "{w:?}");
    }

    #[test]
    fn a_bound_that_was_met_too_early_is_left_again() {
        // Two columns that nearly agree: alone the first would leave its bound by far, beside the held second it would
        // not.
        let a = vec![1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        let b: Vec<f64> = a
            .iter()
            .enumerate()
            .map(|(i, a)| a + 0.1 * (i % 3) as f64)
            .collect();
        let force: Vec<f64> = a.iter().zip(&b).map(|(a, b)| 0.5 * a + 3.0 * b).collect();
        let blocks = Blocks::new(&[a, b], &force);
        let below = |high| Bound { low: -1.0, high };
        let terms = [(0, below(2.0)), (1, below(2.0))];
        let w = blocks.fit(&terms).unwrap();
        let cost = blocks.all.cost(&[0, 1], &w);
        // No other point within the bounds is better.
        for i in 0..=30 {
            for j in 0..=30 {
                let at = |k: i32, c: usize| (-1.0 + 0.1 * f64::from(k)) / blocks.scale[c];
                let there = blocks.all.cost(&[0, 1], &[at(i, 0), at(j, 1)]);
                assert!(there >= cost - 1e-9);
            }
        }
    }
}
