//! Linear systems over a sampling period, exact: a reference must have no integration error.

use nalgebra::{DMatrix, SMatrix, SVector};

/// `x' = A x + B u` with `S` states and `I` inputs, sampled.
#[derive(Clone, Debug)]
pub struct Linear<const S: usize, const I: usize> {
    transition: SMatrix<f64, S, S>,
    held: SMatrix<f64, S, I>,
    rising: SMatrix<f64, S, I>,
    /// The state.
    pub state: SVector<f64, S>,
}

impl<const S: usize, const I: usize> Linear<S, I> {
    /// At rest. Inputs are linear between samples; a held input is a line of zero slope.
    pub fn new(a: &SMatrix<f64, S, S>, b: &SMatrix<f64, S, I>, period_s: f64) -> Self {
        // (x, u, du) over a period of length 1: x' = A T x + B T u, u' = du, du' = 0 (Franklin, Powell and Workman,
        // Digital Control of Dynamic Systems, section 4.3).
        let mut whole = DMatrix::zeros(S + 2 * I, S + 2 * I);
        whole.view_mut((0, 0), (S, S)).copy_from(&(a * period_s));
        whole.view_mut((0, S), (S, I)).copy_from(&(b * period_s));
        for i in 0..I {
            whole[(S + i, S + I + i)] = 1.0;
        }
        let over = whole.exp();
        Self {
            transition: over.fixed_view::<S, S>(0, 0).into_owned(),
            held: over.fixed_view::<S, I>(0, S).into_owned(),
            rising: over.fixed_view::<S, I>(0, S + I).into_owned(),
            state: SVector::zeros(),
        }
    }

    /// Transition over a period.
    pub fn transition(&self) -> &SMatrix<f64, S, S> {
        &self.transition
    }

    /// Effect of inputs held over a period.
    pub fn held(&self) -> &SMatrix<f64, S, I> {
        &self.held
    }

    /// Effect of inputs that rise by 1 over a period, beyond that of holding their first values.
    pub fn rising(&self) -> &SMatrix<f64, S, I> {
        &self.rising
    }

    /// One period in which the inputs go from `from` to `to`.
    #[inline]
    pub fn step(&mut self, from: &SVector<f64, I>, to: &SVector<f64, I>) {
        self.state = self.transition * self.state + self.held * from + self.rising * (to - from);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_oscillator_under_a_ramp_is_exact_at_any_period() {
        // x'' = -w^2 x + t: x = (t - sin(w t) / w) / w^2.
        let w: f64 = 3.0;
        let a = SMatrix::<f64, 2, 2>::new(0.0, 1.0, -w * w, 0.0);
        let b = SMatrix::<f64, 2, 1>::new(0.0, 1.0);
        let mut x = Linear::new(&a, &b, 0.7);
        for i in 0..100 {
            let t = 0.7 * f64::from(i);
            x.step(&SVector::from([t]), &SVector::from([t + 0.7]));
            let t = t + 0.7;
            let exact = (t - (w * t).sin() / w) / (w * w);
            assert!((x.state[0] - exact).abs() < 1e-11 * t);
        }
    }
}
