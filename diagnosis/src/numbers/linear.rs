//! Least squares with bounds and prior knowledge, for a handful of unknowns.

use crate::numbers::signals::add_columns;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Normal equations of a least-squares problem.
#[derive(Clone, Debug)]
pub struct Normal {
    /// `A^T A` plus the precision of prior knowledge.
    pub matrix: DMatrix<f64>,
    /// `A^T b` plus its pull.
    pub right: DVector<f64>,
    /// `b^T b`.
    pub square: f64,
}

/// Bounds of an unknown.
#[derive(Clone, Copy, Debug)]
pub struct Bound {
    /// Smallest value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

impl Bound {
    /// Unbounded.
    pub const FREE: Self = Self {
        low: f64::NEG_INFINITY,
        high: f64::INFINITY,
    };

    /// At most this far from 0.
    pub const fn within(most: f64) -> Self {
        Self {
            low: -most,
            high: most,
        }
    }

    /// How far a value may move.
    pub fn from(&self, value: f64) -> Self {
        Self {
            low: self.low - value,
            high: self.high - value,
        }
    }

    /// True if it can hardly differ from 1: the amplitude of something that acts once.
    pub fn is_once(&self) -> bool {
        self.low > 0.5 && self.high < 1.5
    }

    /// 0 or more.
    pub const POSITIVE: Self = Self {
        low: 0.0,
        high: f64::INFINITY,
    };
}

/// The minimum within the bounds, fixing unknowns that would leave them; `None` if the equations have no solution.
pub fn solve(normal: &Normal, bounds: &[Bound]) -> Option<(DVector<f64>, f64)> {
    let n = bounds.len();
    let mut fixed: Vec<Option<f64>> = vec![None; n];
    // Each round fixes at least one unknown.
    for _ in 0..=n {
        let free: Vec<usize> = (0..n).filter(|&i| fixed[i].is_none()).collect();
        let mut x = DVector::from_iterator(n, fixed.iter().map(|f| f.unwrap_or(0.0)));
        if !free.is_empty() {
            let pull = &normal.right - &normal.matrix * &x;
            let scale = |i: usize| {
                1.0 / normal.matrix[(free[i], free[i])]
                    .max(f64::MIN_POSITIVE)
                    .sqrt()
            };
            // Scaled to a unit diagonal: units differ by orders of magnitude.
            let a = DMatrix::from_fn(free.len(), free.len(), |i, j| {
                normal.matrix[(free[i], free[j])] * scale(i) * scale(j)
                    + if i == j { 1e-12 } else { 0.0 }
            });
            let b = DVector::from_fn(free.len(), |i, _| pull[free[i]] * scale(i));
            let y = a.cholesky()?.solve(&b);
            for (i, &k) in free.iter().enumerate() {
                x[k] = y[i] * scale(i);
            }
        }
        let worst = free
            .iter()
            .map(|&k| (k, (bounds[k].low - x[k]).max(x[k] - bounds[k].high)))
            .filter(|(_, out)| *out > 0.0)
            .max_by(|a, b| a.1.total_cmp(&b.1));
        match worst {
            Some((k, _)) => fixed[k] = Some(x[k].clamp(bounds[k].low, bounds[k].high)),
            None => {
                let cost =
                    normal.square - 2.0 * normal.right.dot(&x) + (&normal.matrix * &x).dot(&x);
                return cost.is_finite().then_some((x, cost.max(0.0)));
            }
        }
    }
    None
}

/// Sum of products.
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Sixteen sums at a time, which the processor can compute in parallel.
    const SUMS: usize = 16;
    let mut sums = [0.0; SUMS];
    let (ac, bc) = (a.chunks_exact(SUMS), b.chunks_exact(SUMS));
    let rest: f64 = ac
        .remainder()
        .iter()
        .zip(bc.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in ac.zip(bc) {
        for i in 0..SUMS {
            sums[i] += x[i] * y[i];
        }
    }
    rest + sums.iter().sum::<f64>()
}

/// Scalar products of all `columns` with each other.
pub fn gram(columns: &[Vec<f64>]) -> DMatrix<f64> {
    let n = columns.len();
    let mut matrix = DMatrix::from_fn(n, n, |i, j| {
        if j <= i {
            dot(&columns[i], &columns[j])
        } else {
            0.0
        }
    });
    matrix.fill_upper_triangle_with_lower_triangle();
    matrix
}

/// The columns of several records, concatenated.
pub fn stacked(records: impl IntoIterator<Item = Vec<Vec<f64>>>) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = Vec::new();
    for own in records {
        all.resize(own.len(), Vec::new());
        let pairs = all.iter_mut().zip(own);
        pairs.for_each(|(all, own)| all.extend(own));
    }
    all
}

/// Standard deviations of the unknowns of a linear fit from how far segments of what it leaves pull it apart; not known at all
/// where its columns cannot be told apart.
pub fn scatter(columns: &[Vec<f64>], left: &[f64], segments: usize) -> Vec<f64> {
    let Some(factor) = Factor::of(gram(columns)) else {
        return vec![f64::INFINITY; columns.len()];
    };
    let covariance = factor.covariance(&factor.pulls(columns, left, segments), segments);
    let variances = covariance.diagonal();
    variances.iter().map(|v| v.max(0.0).sqrt()).collect()
}

/// Normal equations, scaled and factored once for many right-hand sides.
#[derive(Debug)]
pub struct Factor {
    cholesky: Cholesky<f64, Dyn>,
    scale: Vec<f64>,
}

impl Factor {
    /// `None` if they have no solution.
    pub fn of(mut matrix: DMatrix<f64>) -> Option<Self> {
        let n = matrix.nrows();
        let scale: Vec<f64> = (0..n)
            .map(|i| 1.0 / matrix[(i, i)].max(f64::MIN_POSITIVE).sqrt())
            .collect();
        for i in 0..n {
            for j in 0..n {
                matrix[(i, j)] *= scale[i] * scale[j];
            }
            matrix[(i, i)] += 1e-9;
        }
        Some(Self {
            cholesky: matrix.cholesky()?,
            scale,
        })
    }

    /// The pulls of as many segments of what a fit of `columns` leaves, squared and added up; of scaled unknowns.
    pub fn pulls(&self, columns: &[Vec<f64>], left: &[f64], segments: usize) -> DMatrix<f64> {
        let n = columns.len();
        let mut all = DMatrix::zeros(n, n);
        for k in 0..segments {
            let (from, end) = (k * left.len() / segments, (k + 1) * left.len() / segments);
            let pull = |i: usize, _| dot(&columns[i][from..end], &left[from..end]) * self.scale[i];
            let pull = DVector::from_fn(n, pull);
            all += &pull * pull.transpose();
        }
        all
    }

    /// Covariance of the unknowns, from how far the [`Self::pulls`] of as many segments pull a fit apart.
    pub fn covariance(&self, pulls: &DMatrix<f64>, segments: usize) -> DMatrix<f64> {
        let (n, segments) = (self.scale.len(), segments as f64);
        let free = (segments - n as f64).max(0.5 * segments);
        let inverse = self.cholesky.inverse();
        let scaled = &inverse * pulls * &inverse * (segments / free);
        DMatrix::from_fn(n, n, |i, j| scaled[(i, j)] * self.scale[i] * self.scale[j])
    }

    /// A signal's regression on `columns`.
    pub fn regression(&self, columns: &[Vec<f64>], signal: &[f64]) -> Vec<f64> {
        let right = |i: usize, _| dot(&columns[i], signal) * self.scale[i];
        let share = self.cholesky.solve(&DVector::from_fn(columns.len(), right));
        share.iter().zip(&self.scale).map(|(x, s)| x * s).collect()
    }

    /// Adds a signal's regression on `columns` to that signal, times a factor.
    pub fn add_regression(&self, columns: &[Vec<f64>], signal: &mut [f64], factor: f64) {
        let shares = self.regression(columns, signal);
        add_columns(signal, columns, &shares, factor);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_hold_and_the_rest_makes_the_best_of_it() {
        // y = 2 a + 3 b with a bounded by 1: b absorbs what it can.
        let columns = [vec![1.0, 0.0, 1.0], vec![0.0, 1.0, 1.0]];
        let b = [2.0, 3.0, 5.0];
        let normal = Normal {
            matrix: gram(&columns),
            right: DVector::from_fn(2, |i, _| dot(&columns[i], &b)),
            square: dot(&b, &b),
        };
        let (x, cost) = solve(&normal, &[Bound::FREE, Bound::FREE]).unwrap();
        assert!((x[0] - 2.0).abs() < 1e-9 && (x[1] - 3.0).abs() < 1e-9 && cost < 1e-9);
        let (x, cost) = solve(
            &normal,
            &[
                Bound {
                    low: 0.0,
                    high: 1.0,
                },
                Bound::FREE,
            ],
        )
        .unwrap();
        assert!(
            (x[0] - 1.0).abs() < 1e-12 && (x[1] - 3.5).abs() < 1e-9 && (cost - 1.5).abs() < 1e-9
        );
    }
}
