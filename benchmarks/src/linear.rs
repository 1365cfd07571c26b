//! Linear systems side by side, and first-order sections by the trapezoidal rule. A single system is [`plant::linear::Linear`].

use nalgebra::SMatrix;

/// `L` linear systems of the same size side by side, with `I` inputs that are constant over a period. Every lane has the same
/// operations in the same order as it would have alone.
#[derive(Clone, Debug)]
pub struct Lanes<const S: usize, const I: usize, const L: usize> {
    /// By column, then by row: all rows add their product with one state at once.
    transition: [[[f64; L]; S]; S],
    input: [[[f64; L]; S]; I],
    /// The states.
    pub state: [[f64; L]; S],
}

impl<const S: usize, const I: usize, const L: usize> Lanes<S, I, L> {
    /// Systems at rest, from transition and input matrices.
    pub fn new(systems: &[(SMatrix<f64, S, S>, SMatrix<f64, S, I>); L]) -> Self {
        use std::array::from_fn;
        Self {
            transition: from_fn(|j| from_fn(|i| from_fn(|l| systems[l].0[(i, j)]))),
            input: from_fn(|j| from_fn(|i| from_fn(|l| systems[l].1[(i, j)]))),
            state: [[0.0; L]; S],
        }
    }

    /// Advances by one period.
    #[inline(always)]
    pub fn step(&mut self, input: &[[f64; L]; I]) {
        let mut next = [[0.0; L]; S];
        let columns = self.transition.iter().zip(&self.state);
        for (column, state) in columns.chain(self.input.iter().zip(input)) {
            for (next, row) in next.iter_mut().zip(column) {
                for l in 0..L {
                    next[l] += row[l] * state[l];
                }
            }
        }
        self.state = next;
    }
}

/// `(b1 s + b0) / (a1 s + a0)` by the trapezoidal rule.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    input: [f64; 2],
    output: f64,
    past: [f64; 2],
}

impl Section {
    /// A section at rest, from the coefficients of `s` and of 1.
    pub fn new(numerator: [f64; 2], denominator: [f64; 2], period_s: f64) -> Self {
        let pair = |p: [f64; 2]| [2.0 * p[0] / period_s + p[1], p[1] - 2.0 * p[0] / period_s];
        let (b, a) = (pair(numerator), pair(denominator));
        Self {
            input: [b[0] / a[0], b[1] / a[0]],
            output: a[1] / a[0],
            past: [0.0; 2],
        }
    }

    /// The output at this sample.
    #[inline]
    pub fn step(&mut self, input: f64) -> f64 {
        let output =
            self.input[0] * input + self.input[1] * self.past[0] - self.output * self.past[1];
        self.past = [input, output];
        output
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_section_has_its_gain_and_phase() {
        let period = 1.0 / 4096.0;
        let mut lead = Section::new([50.8, 50.8 * 168.6], [1.0, 8570.0], period);
        let w = std::f64::consts::TAU * 5.0;
        // Correlate over whole cycles after the transient.
        let (mut re, mut im) = (0.0, 0.0);
        let n = 4096;
        for i in 0..2 * n {
            let t = f64::from(i) * period;
            let y = lead.step((w * t).sin());
            if i >= n {
                re += y * (w * t).sin() * 2.0 / f64::from(n);
                im += y * (w * t).cos() * 2.0 / f64::from(n);
            }
        }
        let s = nalgebra::Complex::new(0.0, w);
        let exact = (s + 168.6) * 50.8 / (s + 8570.0);
        assert!((re - exact.re).abs() < 1e-4 && (im - exact.im).abs() < 1e-4);
    }
}
