//! Fits the declared parameters to whitened records.

use crate::model::base::Base;
use crate::numbers::linear::{Normal, dot, gram, solve};
use crate::numbers::signals::difference;
use crate::prepare::noise::Noise;
use crate::prepare::problem::Problem;
use nalgebra::DVector;

/// Largest deviation of the cost from what the last step predicted, as a fraction.
const SETTLED: f64 = 1e-4;
/// A specimen's force is linear in its parameters but for effects relative to its stiffness; an actuator's, nearly so.
const ROUNDS: usize = 5;

/// The best changes of the free declared parameters, linearised about the problem's values, and the cost that they
/// predict: squares of the whitened residual plus those of the prior.
fn step(problem: &Problem, base: &Base, noise: &Noise) -> Option<(DVector<f64>, f64)> {
    let mut residual = Vec::new();
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); base.free.len()];
    for segment in &problem.segments {
        let left = difference(&segment.target, &segment.signals.base);
        noise.whiten_into(&segment.judged(&left), &mut residual);
        let own = problem.base_columns(base, segment);
        for (raw, white) in own.into_iter().zip(&mut columns) {
            noise.whiten_into(&segment.judged(&raw), white);
        }
    }
    let mut normal = Normal {
        matrix: gram(&columns),
        right: DVector::from_fn(columns.len(), |i, _| dot(&columns[i], &residual)),
        square: dot(&residual, &residual),
    };
    // Declared values are known to a tolerance.
    for (i, f) in base.free.iter().enumerate() {
        let off = base.values[f.index] - problem.theta[f.index];
        let precision = f.tolerance.powi(-2);
        normal.matrix[(i, i)] += precision;
        normal.right[i] += precision * off;
        normal.square += precision * off * off;
    }
    solve(&normal, &base.bounds(&problem.theta))
}

/// The problem with its declared parameters fitted; `None` if the equations have no solution.
pub fn settle(problem: &Problem, base: &Base, noise: &Noise) -> Option<Problem> {
    let mut problem = problem.clone();
    let mut promised = f64::INFINITY;
    for _ in 0..ROUNDS {
        let (changes, cost) = step(&problem, base, noise)?;
        let mut theta = problem.theta;
        for (f, change) in base.free.iter().zip(&changes) {
            theta[f.index] += change;
        }
        problem.set(base, theta);
        let settled = (cost - promised).abs() < SETTLED * cost.max(1.0);
        promised = cost;
        if settled {
            break;
        }
    }
    Some(problem)
}
