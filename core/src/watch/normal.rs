//! Normal equations of a regression with columns in units of half a tolerance, and every hypothesis of a single cause
//! from one factorization.

use crate::float::larger;

/// Weighted sums of a regression with `M` columns, and so `T` products: the sum of the numbers 1 to `M`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Normal<const M: usize, const T: usize> {
    /// Products of columns: the lower triangle, row by row.
    a: [f32; T],
    b: [f32; M],
    /// Sums of squares of the quantity to be explained, and of the motion.
    total: f32,
    motion: f32,
    pub(super) weight: f32,
}

/// The answer of a regression.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved<const M: usize> {
    /// Each column's coefficient if freed alone, in half tolerances, and its variance.
    pub(super) theta: [f32; M],
    pub(super) variance: [f32; M],
    /// Fraction of the residual that all columns freed together explain, and the mean square that they leave.
    pub(super) explained: f32,
    pub(super) left: f32,
}

/// The known noise of a regression: variance of a sample, squares of a floor and of a fraction of the motion, and how
/// many samples count as one because they are coloured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    pub(super) white: f32,
    pub(super) floor: f32,
    pub(super) of_motion: f32,
    pub(super) coloured: f32,
}

/// Twice the log-likelihood ratio of freeing a single column, from its coefficient and variance, half tolerances; 0 if
/// the motion carries no information on it.
pub(super) fn ratio(theta: f32, variance: f32) -> f32 {
    theta * theta / (variance + 1.0)
}

/// Prior variance of a free column, in half tolerances squared.
const FREE: f32 = 900.0;
/// Fraction of the free fit's residual that counts as noise.
const LEFT_COUNTS: f32 = 0.15;

impl<const M: usize, const T: usize> Normal<M, T> {
    pub(super) const fn new() -> Self {
        Self {
            a: [0.0; T],
            b: [0.0; M],
            total: 0.0,
            motion: 0.0,
            weight: 0.0,
        }
    }

    /// Forgets by the factor `keeps` and adds a sample: columns, quantity to be explained, motion, peaks.
    #[inline(never)] // Unrolled at every call it would be a good part of an image.
    pub(super) fn add(&mut self, keeps: f32, row: &[f32; M], residual: f32, motion: f32) {
        let mut products = self.a.iter_mut();
        for j in 0..M {
            for (a, other) in products.by_ref().take(j + 1).zip(row) {
                *a = keeps * *a + row[j] * other;
            }
            self.b[j] = keeps * self.b[j] + row[j] * residual;
        }
        self.total = keeps * self.total + residual * residual;
        self.motion = keeps * self.motion + motion * motion;
        self.weight = keeps * self.weight + 1.0;
    }

    /// The hypotheses; `left_before` is the mean square that the free fit left while the test was sound.
    #[inline(never)]
    pub(super) fn solve(&self, noise: &Noise, left_before: f32) -> Option<Solved<M>> {
        if !(self.weight > 1.0) {
            return None;
        }
        let known = noise.white
            + noise.coloured
                * (noise.floor + noise.of_motion * self.motion / self.weight + left_before);
        let free = self.factors(known, 1.0 / FREE)?.solve(self.per(known));
        let left = larger(0.0, self.left_by(&free));
        let variance = known + noise.coloured * LEFT_COUNTS * left / self.weight;
        let factors = self.factors(variance, 1.0)?;
        let (mean, p) = (factors.solve(self.per(variance)), factors.variances());
        let mut solved = Solved {
            theta: [0.0; M],
            variance: [0.0; M],
            explained: if self.total > 0.0 {
                1.0 - left / self.total
            } else {
                0.0
            },
            left: left / self.weight,
        };
        let mut finite = true;
        for j in 0..M {
            // A variance is at most the prior's: without information from the motion the freedom is 0.
            let freedom = 1.0 - p[j];
            if freedom > 1e-3 {
                let per = 1.0 / freedom;
                solved.theta[j] = mean[j] * per;
                solved.variance[j] = p[j] * per;
                finite &= ratio(solved.theta[j], solved.variance[j]).is_finite();
            }
        }
        finite.then_some(solved)
    }

    /// The quantity to be explained, divided by a variance.
    fn per(&self, variance: f32) -> [f32; M] {
        let per = 1.0 / variance;
        self.b.map(|b| b * per)
    }

    /// The sum of squares that these coefficients leave.
    fn left_by(&self, theta: &[f32; M]) -> f32 {
        let mut products = self.a.iter();
        let mut left = self.total;
        for j in 0..M {
            let mut off = -self.b[j];
            for (a, other) in products.by_ref().take(j).zip(theta) {
                off += a * other;
            }
            let own = products.next().map_or(0.0, |a| a * theta[j]);
            left += theta[j] * (2.0 * off + own);
        }
        left
    }

    /// The inverse of the covariance under a prior of precision `ridge` in every column.
    #[inline(never)]
    fn factors(&self, variance: f32, ridge: f32) -> Option<Factors<M>> {
        let per = 1.0 / variance;
        let mut products = self.a.iter();
        let mut precision = [[0.0; M]; M];
        for (j, row) in precision.iter_mut().enumerate() {
            for (own, a) in row.iter_mut().zip(products.by_ref().take(j + 1)) {
                *own = a * per;
            }
            row[j] += ridge;
        }
        Factors::of(precision)
    }
}

/// A positive definite matrix as L D L', with ones on the diagonal of L: that needs no square roots.
#[derive(Clone, Copy, Debug)]
struct Factors<const M: usize> {
    /// Below the diagonal.
    l: [[f32; M]; M],
    /// One over D.
    per_d: [f32; M],
}

impl<const M: usize> Factors<M> {
    /// Factors the matrix whose lower triangle is given; `None` if it is not positive definite.
    fn of(mut l: [[f32; M]; M]) -> Option<Self> {
        let mut per_d = [0.0; M];
        for j in 0..M {
            let mut row = l[j];
            for k in 0..j {
                for i in 0..k {
                    row[k] -= row[i] * l[k][i];
                }
            }
            let mut d = row[j];
            for k in 0..j {
                let of_d = row[k];
                row[k] *= per_d[k];
                d -= of_d * row[k];
            }
            if !(d > 0.0) {
                return None;
            }
            (l[j], per_d[j]) = (row, 1.0 / d);
        }
        Some(Self { l, per_d })
    }

    /// Solves for `b`.
    #[inline(never)]
    fn solve(&self, b: [f32; M]) -> [f32; M] {
        let mut x = b;
        for j in 0..M {
            for k in 0..j {
                x[j] -= self.l[j][k] * x[k];
            }
        }
        for j in (0..M).rev() {
            x[j] *= self.per_d[j];
            for k in j + 1..M {
                x[j] -= self.l[k][j] * x[k];
            }
        }
        x
    }

    /// The diagonal of the inverse.
    #[inline(never)]
    fn variances(&self) -> [f32; M] {
        let mut p = [0.0; M];
        for k in 0..M {
            // A column of the inverse of L.
            let mut t = [0.0; M];
            t[k] = 1.0;
            p[k] = self.per_d[k];
            for j in k + 1..M {
                for i in k..j {
                    t[j] -= self.l[j][i] * t[i];
                }
                p[k] += t[j] * t[j] * self.per_d[j];
            }
        }
        p
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_factors_solve_and_have_the_diagonal_of_the_inverse() {
        let a = [[4.0, 0.0, 0.0], [1.0, 3.0, 0.0], [-0.5, 0.7, 2.0]];
        let at = |i: usize, j: usize| if i <= j { a[j][i] } else { a[i][j] };
        let factors = Factors::of(a).unwrap();
        for j in 0..3 {
            // A column of the inverse.
            let mut unit = [0.0; 3];
            unit[j] = 1.0;
            let column = factors.solve(unit);
            for (k, one) in unit.into_iter().enumerate() {
                let product: f32 = (0..3).map(|i| at(k, i) * column[i]).sum();
                assert!((product - one).abs() < 1e-6, "{j} {k}: {product}");
            }
            let variance = factors.variances()[j];
            assert!((variance - column[j]).abs() < 1e-6, "{j}: {variance}");
        }
        assert!(Factors::of([[-1.0_f32]]).is_none());
    }

    #[test]
    fn each_hypothesis_is_the_fit_with_that_column_free() {
        // Two columns; a residual of 10 half tolerances of the first and some noise.
        let mut n = Normal::<2, 3>::new();
        let noise = Noise {
            white: 1e-4,
            floor: 0.0,
            of_motion: 0.0,
            coloured: 0.0,
        };
        for i in 0..500 {
            let t = i as f32 * 0.05;
            let row = [0.01 * libm::sinf(t), 0.01 * libm::cosf(t)];
            let noisy = 0.01 * libm::sinf(37.1 * t);
            n.add(1.0, &row, 10.0 * row[0] + noisy, 1.0);
        }
        let s = n.solve(&noise, 0.0).unwrap();
        assert!(
            (s.theta[0] - 10.0).abs() < 2.0 * libm::sqrtf(s.variance[0]),
            "{s:?}"
        );
        let d = |s: &Solved<2>| [0, 1].map(|j| ratio(s.theta[j], s.variance[j]));
        assert!(d(&s)[0] > 20.0 && d(&s)[1] < 2.0, "{s:?}");
        // A motion without information names nothing.
        let mut still = Normal::<2, 3>::new();
        for _ in 0..500 {
            still.add(1.0, &[0.0, 0.0], 0.01, 0.0);
        }
        assert_eq!(d(&still.solve(&noise, 0.0).unwrap()), [0.0, 0.0]);
    }
}
