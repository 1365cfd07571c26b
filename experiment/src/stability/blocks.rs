//! The parts of the loop as linear systems in discrete time.
//!
//! A [`StateRow`] is a row: what a quantity is, as a linear function of the loop's state at the start of an integration
//! step. Blocks pass rows on as the real parts pass numbers, so a step is written down once, as it runs, and what the
//! states have become after it are the rows of the transition matrix.

use nalgebra::{Complex, DMatrix, DVector};
use std::collections::VecDeque;

/// A quantity as a linear function of the state at the start of the step.
pub type StateRow = DVector<f64>;

/// Something with a state.
pub trait Block {
    /// Its states, always in the same order.
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut StateRow>);
}

/// A signal of nothing yet: rows get their length when the loop is put together.
pub fn nothing() -> StateRow {
    DVector::zeros(0)
}

/// A delay of any number of control periods: the cubic through the four samples around it.
#[derive(Clone, Debug)]
pub struct Delay {
    past: VecDeque<StateRow>,
    first: usize,
    weights: [f64; 4],
}

impl Delay {
    /// By `periods`, at least 0.
    pub fn new(periods: f64) -> Self {
        let periods = if (periods - periods.round()).abs() < 1e-9 {
            periods.round()
        } else {
            periods
        };
        let first = (periods.floor() as usize).saturating_sub(1);
        let d = periods - first as f64;
        let weights = [
            (1.0 - d) * (2.0 - d) * (3.0 - d) / 6.0,
            d * (2.0 - d) * (3.0 - d) / 2.0,
            d * (d - 1.0) * (3.0 - d) / 2.0,
            d * (d - 1.0) * (d - 2.0) / 6.0,
        ];
        Self::from_weights(first, weights)
    }

    /// By `periods`, on the straight line between two samples, as core's model of an actuator has it.
    pub fn straight(periods: f64) -> Self {
        let whole = periods.floor();
        let fraction = periods - whole;
        Self::from_weights(whole as usize, [1.0 - fraction, fraction, 0.0, 0.0])
    }

    fn from_weights(first: usize, weights: [f64; 4]) -> Self {
        // Only what is looked at is a state.
        let deepest = weights.iter().rposition(|w| *w != 0.0).unwrap_or(0);
        Self {
            past: vec![nothing(); first + deepest].into(),
            first,
            weights,
        }
    }

    /// One control period.
    pub fn step(&mut self, input: StateRow) -> StateRow {
        self.past.push_front(input);
        let mut out = self.past[0].clone() * 0.0;
        for (k, w) in self.weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
            out.axpy(*w, &self.past[self.first + k], 1.0);
        }
        self.past.pop_back();
        out
    }

    /// Output per input at `z`.
    pub fn response(&self, z: Complex<f64>) -> Complex<f64> {
        let taps = self.weights.iter().enumerate();
        taps.map(|(k, w)| z.powi(-((self.first + k) as i32)) * *w)
            .sum()
    }
}

impl Block for Delay {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut StateRow>) {
        all.extend(&mut self.past);
    }
}

/// `x = F x + g u`, its output the first of `x`.
#[derive(Clone, Debug)]
pub struct Lag {
    transition: DMatrix<f64>,
    input: DVector<f64>,
    state: Vec<StateRow>,
}

impl Lag {
    /// From its matrices.
    pub fn new(transition: DMatrix<f64>, input: DVector<f64>) -> Self {
        Self {
            state: vec![nothing(); input.len()],
            transition,
            input,
        }
    }

    /// A continuous system `x' = A x + b u` whose input is held over `period_s`.
    pub fn held(a: &DMatrix<f64>, b: &DVector<f64>, period_s: f64) -> Self {
        let n = b.len();
        let mut whole = DMatrix::zeros(n + 1, n + 1);
        whole.view_mut((0, 0), (n, n)).copy_from(&(a * period_s));
        whole.view_mut((0, n), (n, 1)).copy_from(&(b * period_s));
        let over = whole.exp();
        Self::new(
            over.view((0, 0), (n, n)).into_owned(),
            over.view((0, n), (n, 1)).column(0).into_owned(),
        )
    }

    /// `x' = (u - x) / T`.
    pub fn first_order(time_constant_s: f64, period_s: f64) -> Self {
        let stays = (-period_s / time_constant_s).exp();
        Self::new(
            DMatrix::from_element(1, 1, stays),
            DVector::from_element(1, 1.0 - stays),
        )
    }

    /// `x'' = w^2 (u - x) - 2 zeta w x'` with `2 zeta / w = delay_s`.
    pub fn second_order(delay_s: f64, zeta: f64, period_s: f64) -> Self {
        let w = 2.0 * zeta / delay_s;
        let a = DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -w * w, -2.0 * zeta * w]);
        Self::held(&a, &DVector::from_row_slice(&[0.0, w * w]), period_s)
    }

    /// `F` and `g`.
    pub fn matrices(&self) -> (&DMatrix<f64>, &DVector<f64>) {
        (&self.transition, &self.input)
    }

    /// One control period.
    pub fn step(&mut self, input: &StateRow) -> StateRow {
        let mut next: Vec<StateRow> = Vec::with_capacity(self.state.len());
        for i in 0..self.state.len() {
            let mut row = input * self.input[i];
            for (j, x) in self.state.iter().enumerate() {
                row.axpy(self.transition[(i, j)], x, 1.0);
            }
            next.push(row);
        }
        self.state = next;
        self.state[0].clone()
    }

    /// Output per input at `z`.
    pub fn response(&self, z: Complex<f64>) -> Complex<f64> {
        let n = self.input.len();
        // X = F X / z + g U.
        let m = DMatrix::identity(n, n) - self.transition.map(|x| Complex::new(x, 0.0) / z);
        let g = self.input.map(|x| Complex::new(x, 0.0));
        m.lu()
            .solve(&g)
            .map_or(Complex::new(f64::NAN, 0.0), |x| x[0])
    }
}

impl Block for Lag {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut StateRow>) {
        all.extend(&mut self.state);
    }
}

/// Velocity and acceleration of what moves, by the backward differences of the simulated rig.
#[derive(Clone, Debug)]
pub struct Differences {
    rate_hz: f64,
    past: [StateRow; 3],
}

impl Differences {
    /// At `rate_hz`.
    pub fn new(rate_hz: f64) -> Self {
        Self {
            rate_hz,
            past: [nothing(), nothing(), nothing()],
        }
    }

    /// Velocity and acceleration at this sample.
    pub fn step(&mut self, x: &StateRow) -> [StateRow; 2] {
        let [x1, x2, x3] = &self.past;
        let velocity = (x * 3.0 - x1 * 4.0 + x2) * (0.5 * self.rate_hz);
        let acceleration = (x * 2.0 - x1 * 5.0 + x2 * 4.0 - x3) * (self.rate_hz * self.rate_hz);
        self.past.rotate_right(1);
        self.past[0] = x.clone();
        [velocity, acceleration]
    }
}

impl Block for Differences {
    fn states<'a>(&'a mut self, all: &mut Vec<&'a mut StateRow>) {
        all.extend(&mut self.past);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs a block of one input on numbers: rows of length 1.
    fn drive(mut step: impl FnMut(f64) -> f64, w: f64, n: usize) -> Complex<f64> {
        let mut sum = Complex::new(0.0, 0.0);
        for i in 0..2 * n {
            let t = i as f64;
            let y = step((w * t).cos());
            if i >= n {
                sum += Complex::from_polar(2.0 / n as f64, -w * t) * y;
            }
        }
        sum
    }

    fn at_rest(block: &mut impl Block) {
        let mut all = Vec::new();
        block.states(&mut all);
        for s in all {
            *s = DVector::zeros(1);
        }
    }

    #[test]
    fn what_a_block_does_is_what_its_response_says() {
        let n = 2000;
        let w = std::f64::consts::TAU * 20.0 / n as f64;
        let z = Complex::from_polar(1.0, w);
        for periods in [0.0, 1.0, 2.5, 8.25, 60.0] {
            let mut line = Delay::new(periods);
            at_rest(&mut line);
            let found = drive(|x| line.step(DVector::from_element(1, x))[0], w, n);
            assert!((found - line.response(z)).norm() < 1e-9, "{periods}");
            assert!((found - Complex::from_polar(1.0, -w * periods)).norm() < 1e-4);
        }
        for mut lag in [
            Lag::first_order(0.004, 5e-4),
            Lag::second_order(0.02, 0.7, 5e-4),
        ] {
            at_rest(&mut lag);
            let found = drive(|x| lag.step(&DVector::from_element(1, x))[0], w, n);
            assert!((found - lag.response(z)).norm() < 1e-9);
        }
    }
}
