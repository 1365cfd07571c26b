//! Bounded least squares by an active set, on normal equations of a handful of unknowns. Small and fast: a search needs
//! it a hundred thousand times.

use crate::numbers::linear::{Bound, dot};
use std::ops::Range;

/// Ridge, relative to each unknown's own square: identical columns share their strength.
const RIDGE: f64 = 1e-9;
/// Ridge of free functions: one that a block hardly touches would be arbitrary there.
const SOFT_RIDGE: f64 = 1e-4;

/// Normal equations; unused rows are 0.
#[derive(Clone, Debug)]
pub struct Equations {
    /// Number of unknowns.
    pub n: usize,
    /// Products of columns with columns, row by row.
    pub gram: Vec<f64>,
    /// Products of columns with the target.
    pub right: Vec<f64>,
    /// The target's sum of squares.
    pub square: f64,
    /// Unknowns from this index on are free functions.
    pub soft: usize,
}

impl Equations {
    /// Zero equations for `n` unknowns.
    pub fn zero(n: usize) -> Self {
        Self {
            n,
            gram: vec![0.0; n * n],
            right: vec![0.0; n],
            square: 0.0,
            soft: n,
        }
    }

    /// From these samples of columns and a target.
    pub fn of(columns: &[Vec<f64>], target: &[f64], samples: Range<usize>) -> Self {
        let n = columns.len();
        let own: Vec<&[f64]> = columns.iter().map(|c| &c[samples.clone()]).collect();
        let y = &target[samples];
        let mut all = Self::zero(n);
        for i in 0..n {
            for j in 0..=i {
                let product = dot(own[i], own[j]);
                all.gram[i * n + j] = product;
                all.gram[j * n + i] = product;
            }
            all.right[i] = dot(own[i], y);
        }
        all.square = dot(y, y);
        all
    }

    /// Adds equations of the same unknowns, with a weight.
    pub fn add(&mut self, other: &Self, weight: f64) {
        for (own, more) in self.gram.iter_mut().zip(&other.gram) {
            *own += weight * more;
        }
        for (own, more) in self.right.iter_mut().zip(&other.right) {
            *own += weight * more;
        }
        self.square += weight * other.square;
        self.soft = other.soft;
    }

    /// Pulls an unknown towards a value.
    pub fn pull(&mut self, unknown: usize, value: f64, weight: f64) {
        self.gram[unknown * self.n + unknown] += weight;
        self.right[unknown] += weight * value;
        self.square += weight * value * value;
    }

    /// The same with each unknown held back by a fraction of its own square, as by Levenberg and Marquardt.
    pub fn damped(&self, damping: f64) -> Self {
        let mut damped = self.clone();
        let diagonal = damped.gram.iter_mut().step_by(self.n + 1);
        diagonal.for_each(|own| *own *= 1.0 + damping);
        damped
    }

    /// Residual squares at these values.
    pub fn left(&self, values: &[f64]) -> f64 {
        let mut left = self.square;
        for i in 0..self.n {
            let row = &self.gram[i * self.n..(i + 1) * self.n];
            let across: f64 = row.iter().zip(values).map(|(g, v)| g * v).sum();
            left += values[i] * (across - 2.0 * self.right[i]);
        }
        left.max(0.0)
    }

    /// Least-squares values within `bounds`; `None` if the equations have no solution.
    pub fn solve(&self, bounds: &[Bound]) -> Option<Vec<f64>> {
        let n = self.n;
        let mut values = vec![0.0; n];
        let mut free = vec![true; n];
        for (i, Bound { low, high }) in bounds.iter().copied().enumerate() {
            if self.gram[i * n + i] <= 0.0 {
                free[i] = false;
                values[i] = 0.0_f64.clamp(low.min(high), high);
            } else if low >= high {
                free[i] = false;
                values[i] = low;
            }
        }
        for _ in 0..3 * n + 1 {
            let at: Vec<usize> = (0..n).filter(|i| free[*i]).collect();
            self.solve_free(&at, &mut values)?;
            let out = |i: usize| (bounds[i].low - values[i]).max(values[i] - bounds[i].high);
            let worst = at.iter().copied().filter(|&i| out(i) > 0.0);
            // Relative to the unknown's own size: units differ.
            let size = |i: usize| out(i) * self.gram[i * n + i].sqrt();
            if let Some(i) = worst.max_by(|&a, &b| size(a).total_cmp(&size(b))) {
                values[i] = values[i].clamp(bounds[i].low, bounds[i].high);
                free[i] = false;
                continue;
            }
            let Some(i) = self.inward(&free, &values, bounds) else {
                return Some(values);
            };
            free[i] = true;
        }
        Some(values)
    }

    /// Of the unknowns at a bound, the one whose release reduces the squares most, if any.
    fn inward(&self, free: &[bool], values: &[f64], bounds: &[Bound]) -> Option<usize> {
        let n = self.n;
        let least = 1e-9 * self.square.max(0.0);
        let held = (0..n).filter(|&i| !free[i] && bounds[i].low < bounds[i].high);
        let fall = |i: usize| {
            let row = &self.gram[i * n..(i + 1) * n];
            let slope = self.right[i] - row.iter().zip(values).map(|(g, v)| g * v).sum::<f64>();
            let inside = if values[i] <= bounds[i].low {
                slope
            } else {
                -slope
            };
            inside.max(0.0).powi(2) / self.gram[i * n + i].max(f64::MIN_POSITIVE)
        };
        held.map(|i| (fall(i), i))
            .filter(|(fall, _)| *fall > least)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, i)| i)
    }

    /// Least squares of the unknowns `at`, all others fixed, by Cholesky.
    fn solve_free(&self, at: &[usize], values: &mut [f64]) -> Option<()> {
        let (n, m) = (self.n, at.len());
        let mut l = vec![0.0; m * m];
        let mut y = vec![0.0; m];
        let held: Vec<usize> = (0..n)
            .filter(|k| values[*k] != 0.0 && !at.contains(k))
            .collect();
        for (i, &row) in at.iter().enumerate() {
            for (j, &column) in at[..=i].iter().enumerate() {
                let mut sum = self.gram[row * n + column];
                if i == j {
                    sum *= 1.0 + if row < self.soft { RIDGE } else { SOFT_RIDGE };
                }
                let (a, b) = (&l[i * m..i * m + j], &l[j * m..j * m + j]);
                sum -= a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                if i == j {
                    if sum <= 0.0 {
                        return None;
                    }
                    l[i * m + i] = sum.sqrt();
                } else {
                    l[i * m + j] = sum / l[j * m + j];
                }
            }
            let mut right = self.right[row];
            right -= held
                .iter()
                .map(|&k| self.gram[row * n + k] * values[k])
                .sum::<f64>();
            let lower = &l[i * m..i * m + i];
            right -= lower.iter().zip(&y).map(|(l, y)| l * y).sum::<f64>();
            y[i] = right / l[i * m + i];
        }
        for i in (0..m).rev() {
            let mut sum = y[i];
            for k in i + 1..m {
                sum -= l[k * m + i] * values[at[k]];
            }
            values[at[i]] = sum / l[i * m + i];
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_squares_within_bounds_are_those_of_a_search_over_a_grid() {
        // Two nearly equal columns: alone the first would leave its bound by far.
        let a = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let b: Vec<f64> = (0..7).map(|i| a[i] + 0.1 * (i % 3) as f64).collect();
        let y: Vec<f64> = (0..7).map(|i| 0.5 * a[i] + 3.0 * b[i]).collect();
        let dot = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(p, q)| p * q).sum::<f64>();
        let equations = Equations {
            n: 2,
            gram: vec![dot(&a, &a), dot(&a, &b), dot(&a, &b), dot(&b, &b)],
            right: vec![dot(&a, &y), dot(&b, &y)],
            square: dot(&y, &y),
            soft: 2,
        };
        let within = Bound {
            low: -1.0,
            high: 2.0,
        };
        let found = equations.solve(&[within; 2]).unwrap();
        let left = equations.left(&found);
        for i in 0..=30 {
            for j in 0..=30 {
                let there = [-1.0 + 0.1 * f64::from(i), -1.0 + 0.1 * f64::from(j)];
                assert!(equations.left(&there) >= left - 1e-9);
            }
        }
        let free = equations.solve(&[Bound::FREE; 2]).unwrap();
        assert!(
            (free[0] - 0.5).abs() < 1e-5 && (free[1] - 3.0).abs() < 1e-5,
            "{free:?}"
        );
    }
}
