//! The declared parameters at their best against whitened records.

use crate::model::base::Base;
use crate::numbers::linear::{Normal, dot, gram, solve};
use crate::numbers::signals::difference;
use crate::prepare::noise::Noise;
use crate::prepare::problem::Problem;
use nalgebra::DVector;

/// Share of the cost by which the last step may be off from what it promised.
const SETTLED: f64 = 1e-4;
/// The specimen's answer is linear in its parameters but for effects relative to its stiffness, the actuator's nearly.
const ROUNDS: usize = 5;

/// The best changes of the free declared parameters, linear around those of the problem, and the cost that they promise: squares of
/// the white residual, and of what was known beforehand.
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
    // What is declared is known to a tolerance.
    for (i, f) in base.free.iter().enumerate() {
        let off = base.values[f.index] - problem.theta[f.index];
        let precision = f.tolerance.powi(-2);
        normal.matrix[(i, i)] += precision;
        normal.right[i] += precision * off;
        normal.square += precision * off * off;
    }
    solve(&normal, &base.bounds(&problem.theta))
}

/// The problem with its declared parameters at their best; `None` where the equations have no solution.
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
