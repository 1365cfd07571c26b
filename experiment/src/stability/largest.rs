//! The largest eigenvalues of a loop with many states.
//!
//! A delay of 60 ms is 120 states, and a polynomial through three of them 360 more; all their eigenvalues take seconds, and
//! `check` asks hundreds of times. What decides is the few that decay slowest. Arnoldi's method finds those, in the
//! transition over so many steps that most of what decays is gone: there they are far apart.

use nalgebra::{Complex, DMatrix, DVector, Schur};

/// Size of the first subspace.
const FIRST: usize = 40;
/// Residual of an eigenvalue that may be the largest, relative to the largest.
const EXACT: f64 = 1e-10;
/// Residual of one that is shown, relative to itself.
const SHOWN: f64 = 1e-4;
/// What lies within this share of the largest may be the largest.
const NEAR: f64 = 0.5;
/// Steps of the search for the eigenvalues of the subspace.
const SEARCHES: usize = 100_000;

/// The largest eigenvalues of `step`, found in `many`, its power by `steps`. None where they are not found in a subspace of
/// half the size.
pub fn largest(
    step: &DMatrix<f64>,
    many: &DMatrix<f64>,
    steps: usize,
) -> Option<Vec<Complex<f64>>> {
    let n = many.nrows();
    let mut space = Subspace::new(n);
    let mut size = FIRST;
    while size <= n / 2 {
        space.grow(many, size);
        if let Some(found) = space.eigenvalues(step, steps) {
            return Some(found);
        }
        if space.closed {
            return None;
        }
        size *= 2;
    }
    None
}

/// An orthonormal basis of what `many` makes of a start, and what `many` is in it.
struct Subspace {
    basis: Vec<DVector<f64>>,
    /// Columns of the Hessenberg matrix, each one longer than its number.
    columns: Vec<DVector<f64>>,
    /// It holds all that comes of the start.
    closed: bool,
}

impl Subspace {
    fn new(n: usize) -> Self {
        // Some of everything, the same every time.
        let start = DVector::from_fn(n, |i, _| 1.0 + (1.0 + (i * i) as f64).sin());
        Self {
            basis: vec![start.normalize()],
            columns: Vec::new(),
            closed: false,
        }
    }

    fn grow(&mut self, many: &DMatrix<f64>, size: usize) {
        while self.columns.len() < size && !self.closed {
            let mut new = many * &self.basis[self.columns.len()];
            let before = new.norm();
            let mut column = DVector::zeros(self.basis.len() + 1);
            // Twice: once leaves what rounding makes of it.
            for _ in 0..2 {
                for (i, q) in self.basis.iter().enumerate() {
                    let along = q.dot(&new);
                    column[i] += along;
                    new.axpy(-along, q, 1.0);
                }
            }
            let rest = new.norm();
            column[self.basis.len()] = rest;
            self.columns.push(column);
            if rest <= 1e-14 * before || !rest.is_finite() {
                self.closed = true;
            } else {
                self.basis.push(new / rest);
            }
        }
    }

    /// Those that are found, where none that may be the largest is missing.
    fn eigenvalues(&self, step: &DMatrix<f64>, steps: usize) -> Option<Vec<Complex<f64>>> {
        let m = self.columns.len();
        let entry = |i: usize, j: usize| self.columns[j].get(i).copied().unwrap_or(0.0);
        let within = DMatrix::from_fn(m, m, |i, j| Complex::new(entry(i, j), 0.0));
        let (turn, triangle) = Schur::try_new(within, f64::EPSILON, SEARCHES)?.unpack();
        let largest = (0..m).map(|i| triangle[(i, i)].norm()).fold(0.0, f64::max);
        let beyond = if self.closed { 0.0 } else { entry(m, m - 1) };
        let mut found = Vec::new();
        for i in 0..m {
            let value = triangle[(i, i)];
            let vector = &turn * eigenvector(&triangle, i);
            let residual = beyond * vector[m - 1].norm() / vector.norm();
            if value.norm() >= NEAR * largest && residual > EXACT * largest {
                return None;
            }
            if residual <= SHOWN * value.norm() {
                // Over many steps the angle has gone round many times: over one it tells.
                let [re, im] = self.full_vectors(&vector);
                let [to_re, to_im] = [step * &re, step * &im];
                let along = Complex::new(
                    re.dot(&to_re) + im.dot(&to_im),
                    re.dot(&to_im) - im.dot(&to_re),
                );
                let modulus = value.norm().powf(1.0 / steps as f64);
                found.push(Complex::from_polar(modulus, along.arg()));
            }
        }
        Some(found)
    }

    /// Real and imaginary part of a vector of the subspace.
    fn full_vectors(&self, vector: &DVector<Complex<f64>>) -> [DVector<f64>; 2] {
        let mut whole = [(); 2].map(|()| DVector::zeros(self.basis[0].len()));
        for (q, y) in self.basis.iter().zip(vector.iter()) {
            whole[0].axpy(y.re, q, 1.0);
            whole[1].axpy(y.im, q, 1.0);
        }
        whole
    }
}

/// The eigenvector of the `i`th eigenvalue of a triangular matrix.
fn eigenvector(triangle: &DMatrix<Complex<f64>>, i: usize) -> DVector<Complex<f64>> {
    let m = triangle.nrows();
    let zero = Complex::new(0.0, 0.0);
    let mut y = DVector::from_element(m, zero);
    y[i] = Complex::new(1.0, 0.0);
    for r in (0..i).rev() {
        let sum: Complex<f64> = (r + 1..=i).map(|s| triangle[(r, s)] * y[s]).sum();
        let apart = triangle[(r, r)] - triangle[(i, i)];
        // Of equal eigenvalues one vector will do.
        y[r] = if apart.norm() > 0.0 {
            -sum / apart
        } else {
            zero
        };
    }
    y
}

#[cfg(test)]
mod tests {
    use super::super::spectrum;
    use super::*;

    /// An oscillator whose force comes `delay` steps late, as a matrix.
    fn late(delay: usize) -> DMatrix<f64> {
        let (h, n) = (0.0063, 2 + delay);
        let mut m = DMatrix::zeros(n, n);
        // u' = u + v, v' = .9998 v - h^2 u (late).
        m[(0, 0)] = 1.0;
        m[(0, 1)] = 1.0;
        m[(1, 1)] = 0.9998;
        m[(1, n - 1)] = -h * h;
        m[(2, 0)] = 1.0;
        for i in 3..n {
            m[(i, i - 1)] = 1.0;
        }
        m
    }

    #[test]
    fn the_largest_are_those_of_the_whole_matrix() {
        for delay in [110, 160] {
            let step = late(delay);
            let many = (0..9).fold(step.clone(), |m, _| &m * &m);
            let few = largest(&step, &many, 512).expect("found");
            let modulus = |z: &[Complex<f64>]| z.iter().map(|z| z.norm()).fold(0.0, f64::max);
            let all = spectrum::eigenvalues(&step);
            assert!((modulus(&few) / modulus(&all) - 1.0).abs() < 1e-10);
            let mode = |z: &[Complex<f64>]| spectrum::modes(z, &[12.6], 5e-4)[0];
            let (a, b) = (mode(&few), mode(&all));
            assert!(
                (a.damping_ratio - b.damping_ratio).abs() < 1e-7,
                "{a:?} {b:?}"
            );
            assert!((a.frequency_hz / b.frequency_hz - 1.0).abs() < 1e-7);
        }
    }
}
