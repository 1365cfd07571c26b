//! Normal equations of a regression whose columns are in units of half a tolerance, and every hypothesis of a single cause
//! from one inverse.

use libm::sqrtf;

/// Weighted sums of a regression with `M` columns, which have `T` products: the columns' numbers from 1 to `M` added up.
#[derive(Clone, Copy, Debug)]
pub(super) struct Normal<const M: usize, const T: usize> {
    /// Products of columns: the lower triangle, row by row.
    a: [f32; T],
    b: [f32; M],
    /// Squares of what is to be explained, and of the motion.
    total: f32,
    motion: f32,
    pub(super) weight: f32,
}

/// What a regression says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solved<const M: usize> {
    /// Each column's coefficient if it alone were free, in half tolerances, and its standard deviation.
    pub(super) theta: [f32; M],
    pub(super) sd: [f32; M],
    /// Share of the residual that all columns free together explain, and the mean square that they leave.
    pub(super) explained: f32,
    pub(super) left: f32,
}

/// What is known of the noise of a regression: variance of a sample, squares of a floor and of a share of the motion, and how
/// many samples stand for one because they are coloured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    pub(super) white: f32,
    pub(super) floor: f32,
    pub(super) of_motion: f32,
    pub(super) coloured: f32,
}

/// Twice the logarithm of the likelihood ratio of letting a column alone go, by its coefficient with the standard deviation, half
/// tolerances; 0 where the motion tells nothing of it.
pub(super) fn ratio(theta: f32, sd: f32) -> f32 {
    theta * theta / (sd * sd + 1.0)
}

/// Prior variance of a free column, in half tolerances squared.
const FREE: f32 = 900.0;
/// Share of what the free fit leaves that counts as noise.
const LEFT_COUNTS: f32 = 0.15;

/// Where the product of the columns `j` and `k` is.
const fn place(j: usize, k: usize) -> usize {
    let (row, column) = if k <= j { (j, k) } else { (k, j) };
    row * (row + 1) / 2 + column
}

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

    /// Forgets by `keeps` and takes a sample in: columns, what is to be explained, the motion, peaks.
    #[inline(never)] // Unrolled at every place that calls it, it would be a good part of an image.
    pub(super) fn add(&mut self, keeps: f32, row: &[f32; M], residual: f32, motion: f32) {
        for j in 0..M {
            for k in 0..=j {
                let a = &mut self.a[place(j, k)];
                *a = keeps * *a + row[j] * row[k];
            }
            self.b[j] = keeps * self.b[j] + row[j] * residual;
        }
        self.total = keeps * self.total + residual * residual;
        self.motion = keeps * self.motion + motion * motion;
        self.weight = keeps * self.weight + 1.0;
    }

    /// The hypotheses, where `left_before` is the mean square that the free fit left while the test was sound.
    #[inline(never)]
    pub(super) fn solve(&self, noise: &Noise, left_before: f32) -> Option<Solved<M>> {
        if !(self.weight > 1.0) {
            return None;
        }
        let known = noise.white
            + noise.coloured
                * (noise.floor + noise.of_motion * self.motion / self.weight + left_before);
        let (_, wide) = self.posterior(known, 1.0 / FREE)?;
        let mut left = self.total;
        for j in 0..M {
            left -= 2.0 * wide[j] * self.b[j];
            for k in 0..M {
                left += wide[j] * self.a[place(j, k)] * wide[k];
            }
        }
        let left = if left > 0.0 { left } else { 0.0 };
        let variance = known + noise.coloured * LEFT_COUNTS * left / self.weight;
        let (p, mu) = self.posterior(variance, 1.0)?;
        let mut solved = Solved {
            theta: [0.0; M],
            sd: [0.0; M],
            explained: if self.total > 0.0 {
                1.0 - left / self.total
            } else {
                0.0
            },
            left: left / self.weight,
        };
        for j in 0..M {
            // P_jj is at most the prior's: what the motion tells nothing of has freedom 0.
            let freedom = 1.0 - p[j][j];
            if freedom > 1e-3 {
                solved.theta[j] = mu[j] / freedom;
                solved.sd[j] = sqrtf(p[j][j] / freedom);
            }
        }
        let mut ratios = (0..M).map(|j| ratio(solved.theta[j], solved.sd[j]));
        ratios.all(f32::is_finite).then_some(solved)
    }

    /// Covariance and mean under a prior of precision `ridge` in every column.
    #[inline(never)]
    fn posterior(&self, variance: f32, ridge: f32) -> Option<([[f32; M]; M], [f32; M])> {
        let per = 1.0 / variance;
        let mut p = [[0.0; M]; M];
        for j in 0..M {
            for k in 0..=j {
                p[j][k] = self.a[place(j, k)] * per;
            }
            p[j][j] += ridge;
        }
        let p = inverse(p)?;
        let mut mu = [0.0; M];
        for j in 0..M {
            for k in 0..M {
                mu[j] += p[j][k] * self.b[k] * per;
            }
        }
        Some((p, mu))
    }
}

/// Inverse of a positive definite matrix of which the lower triangle is given: Cholesky.
#[inline(never)]
fn inverse<const M: usize>(mut l: [[f32; M]; M]) -> Option<[[f32; M]; M]> {
    for j in 0..M {
        for k in 0..=j {
            let mut sum = l[j][k];
            for i in 0..k {
                sum -= l[j][i] * l[k][i];
            }
            if j == k {
                if !(sum > 0.0) {
                    return None;
                }
                l[j][j] = sqrtf(sum);
            } else {
                l[j][k] = sum / l[k][k];
            }
        }
    }
    // The inverse of the triangle, then its square.
    let mut t = [[0.0_f32; M]; M];
    for j in 0..M {
        t[j][j] = 1.0 / l[j][j];
        for k in 0..j {
            let mut sum = 0.0;
            for i in k..j {
                sum -= l[j][i] * t[i][k];
            }
            t[j][k] = sum * t[j][j];
        }
    }
    let mut p = [[0.0; M]; M];
    for j in 0..M {
        for k in 0..=j {
            let mut sum = 0.0;
            for i in j..M {
                sum += t[i][j] * t[i][k];
            }
            (p[j][k], p[k][j]) = (sum, sum);
        }
    }
    Some(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_is_one() {
        let a = [[4.0, 0.0, 0.0], [1.0, 3.0, 0.0], [-0.5, 0.7, 2.0]];
        let p = inverse(a).unwrap();
        for j in 0..3 {
            for k in 0..3 {
                let product: f32 = (0..3)
                    .map(|i| if i <= j { a[j][i] } else { a[i][j] } * p[i][k])
                    .sum();
                let one = if j == k { 1.0 } else { 0.0 };
                assert!((product - one).abs() < 1e-6, "{j} {k}: {product}");
            }
        }
        assert!(inverse([[-1.0_f32]]).is_none());
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
        assert!((s.theta[0] - 10.0).abs() < 2.0 * s.sd[0], "{s:?}");
        let d = |s: &Solved<2>| [0, 1].map(|j| ratio(s.theta[j], s.sd[j]));
        assert!(d(&s)[0] > 20.0 && d(&s)[1] < 2.0, "{s:?}");
        // A motion that tells nothing names nothing.
        let mut still = Normal::<2, 3>::new();
        for _ in 0..500 {
            still.add(1.0, &[0.0, 0.0], 0.01, 0.0);
        }
        assert_eq!(d(&still.solve(&noise, 0.0).unwrap()), [0.0, 0.0]);
    }
}
