//! Effects fitted to whitened records, jointly with the declared parameters.

use crate::base::Base;
use crate::library::candidate::{Candidate, Shape};
use crate::linear::{Bound, Normal, dot, gram, solve};
use crate::noise::Noise;
use crate::problem::{FittedEffect, Problem};
use crate::signals::{Signals, difference};
use nalgebra::{DMatrix, DVector};
use std::borrow::Cow;

/// A problem made linear around its present parameters, with everything white that does not change in a search.
#[derive(Clone, Debug)]
pub struct Frame<'a> {
    problem: &'a Problem,
    base: &'a Base,
    noise: &'a Noise,
    effects: &'a [(Candidate, Vec<f64>)],
    /// What the effects see, segment by segment.
    signals: Vec<Cow<'a, Signals>>,
    residual: Vec<f64>,
    fixed: Vec<Vec<f64>>,
    normal: Normal,
    bounds: Vec<Bound>,
    /// Whitened samples.
    pub samples: usize,
}

/// The best amplitudes for given shapes.
#[derive(Clone, Debug)]
pub struct Amplitudes {
    /// Sum of squares of the white residual and of what was known beforehand.
    pub cost: f64,
    /// Changes of the free declared parameters, then amplitudes of the fixed effects, then of the searched one.
    pub values: Vec<f64>,
}

impl<'a> Frame<'a> {
    /// Linear around `problem.theta`; `fixed` effects keep their shapes and get their amplitudes anew.
    pub fn new(
        problem: &'a Problem,
        base: &'a Base,
        noise: &'a Noise,
        fixed: &'a [(Candidate, Vec<f64>)],
    ) -> Self {
        let stages: Vec<(Candidate, &[f64])> =
            fixed.iter().map(|(c, s)| (*c, s.as_slice())).collect();
        let mut seen = Vec::new();
        let mut residual = Vec::new();
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for segment in &problem.segments {
            let signals = problem.staged(segment, &stages, &problem.scales);
            let left = difference(&segment.target, &signals.base);
            noise.whiten_into(&segment.judged(&left), &mut residual);
            let mut raw = problem.staged_columns(base, segment, &stages);
            for (candidate, shapes) in fixed {
                raw.extend((candidate.columns)(&signals, shapes, &problem.scales));
            }
            seen.push(signals);
            columns.resize(raw.len(), Vec::new());
            for (raw, white) in raw.into_iter().zip(&mut columns) {
                noise.whiten_into(&segment.judged(&raw), white);
            }
        }
        let n = columns.len();
        let mut matrix = gram(&columns);
        let mut right = DVector::from_fn(n, |i, _| dot(&columns[i], &residual));
        let mut square = dot(&residual, &residual);
        // What is declared is known to a tolerance.
        for (i, f) in base.free.iter().enumerate() {
            let (precision, off) = (
                f.tolerance.powi(-2),
                base.values[f.index] - problem.theta[f.index],
            );
            matrix[(i, i)] += precision;
            right[i] += precision * off;
            square += precision * off * off;
        }
        let mut bounds = base.bounds(&problem.theta);
        for (candidate, _) in fixed {
            bounds.extend((candidate.bounds)(&problem.scales));
        }
        // What acts once has the amplitude 1 as soon as the declared parameters are right.
        let amplitudes = bounds.iter().enumerate().skip(base.free.len());
        for (i, _) in amplitudes.filter(|(_, b)| b.is_once()) {
            let precision = ONCE.powi(-2);
            matrix[(i, i)] += precision;
            right[i] += precision;
            square += precision;
        }
        let samples = residual.len();
        Self {
            problem,
            base,
            noise,
            effects: fixed,
            signals: seen,
            residual,
            fixed: columns,
            normal: Normal {
                matrix,
                right,
                square,
            },
            bounds,
            samples,
        }
    }

    /// What acts once has the amplitude 1 from now on.
    fn act_once(&mut self) {
        for bound in self.bounds.iter_mut().filter(|b| b.is_once()) {
            (bound.low, bound.high) = (1.0, 1.0);
        }
    }

    /// Without a further effect.
    pub fn alone(&self) -> Option<Amplitudes> {
        let (x, cost) = solve(&self.normal, &self.bounds)?;
        Some(Amplitudes {
            cost,
            values: x.iter().copied().collect(),
        })
    }

    /// With one more effect of these shapes.
    pub fn with(&self, candidate: &Candidate, shapes: &[f64]) -> Option<Amplitudes> {
        if candidate.stage.is_some() {
            // The parameters, too, act through a stage.
            let mut effects = self.effects.to_vec();
            effects.push((*candidate, shapes.to_vec()));
            return Frame::new(self.problem, self.base, self.noise, &effects).alone();
        }
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for (signals, segment) in self.signals.iter().zip(&self.problem.segments) {
            let raw = (candidate.columns)(signals, shapes, &self.problem.scales);
            columns.resize(raw.len(), Vec::with_capacity(self.samples));
            for (raw, white) in raw.into_iter().zip(&mut columns) {
                self.noise.whiten_into(&segment.judged(&raw), white);
            }
        }
        let (n, m) = (self.fixed.len(), columns.len());
        let matrix = DMatrix::from_fn(n + m, n + m, |i, j| {
            match (i.checked_sub(n), j.checked_sub(n)) {
                (None, None) => self.normal.matrix[(i, j)],
                (Some(i), None) => dot(&columns[i], &self.fixed[j]),
                (None, Some(j)) => dot(&columns[j], &self.fixed[i]),
                (Some(i), Some(j)) => dot(&columns[i], &columns[j]),
            }
        });
        let right = DVector::from_fn(n + m, |i, _| match i.checked_sub(n) {
            None => self.normal.right[i],
            Some(i) => dot(&columns[i], &self.residual),
        });
        let mut bounds = self.bounds.clone();
        bounds.extend((candidate.bounds)(&self.problem.scales));
        let normal = Normal {
            matrix,
            right,
            square: self.normal.square,
        };
        let (x, cost) = solve(&normal, &bounds)?;
        cost.is_finite().then(|| Amplitudes {
            cost,
            values: x.iter().copied().collect(),
        })
    }

    /// The best shapes of a candidate, its amplitudes and cost: a grid, then downhill from the best two points of it.
    pub fn search(&self, candidate: &Candidate) -> Option<(Vec<f64>, Amplitudes)> {
        let shapes = (candidate.shapes)(&self.problem.scales);
        if shapes.is_empty() {
            return self.with(candidate, &[]).map(|a| (Vec::new(), a));
        }
        let value =
            |u: &[f64]| -> Vec<f64> { u.iter().zip(&shapes).map(|(u, s)| at(s, *u)).collect() };
        let cost = |u: &[f64]| self.with(candidate, &value(u)).map_or(f64::MAX, |a| a.cost);
        let mut starts: Vec<(Vec<f64>, f64)> = grid(&shapes)
            .into_iter()
            .map(|u| {
                let c = cost(&u);
                (u, c)
            })
            .collect();
        starts.sort_by(|a, b| a.1.total_cmp(&b.1));
        let width: Vec<f64> = shapes.iter().map(|s| 0.6 / s.grid.max(2) as f64).collect();
        let best = starts
            .iter()
            .take(2)
            .map(|(u, c)| downhill(&cost, u, *c, &width, FINEST))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        let shapes = value(&best.0);
        self.with(candidate, &shapes).map(|a| (shapes, a))
    }
}

/// Step of a shape between 0 and 1 at which a search ends.
const FINEST: f64 = 4e-3;

/// A shape from its place between 0 and 1.
fn at(s: &Shape, u: f64) -> f64 {
    if s.low <= 0.0 {
        return s.low + (s.high - s.low) * u.clamp(0.0, 1.0);
    }
    s.low * (s.high / s.low).powf(u.clamp(0.0, 1.0))
}

fn grid(shapes: &[Shape]) -> Vec<Vec<f64>> {
    shapes.iter().fold(vec![Vec::new()], |points, shape| {
        let along = |p: Vec<f64>| {
            (0..shape.grid).map(move |i| {
                let mut p = p.clone();
                p.push((i as f64 + 0.5) / shape.grid as f64);
                p
            })
        };
        points.into_iter().flat_map(along).collect()
    })
}

/// Pattern search from `u`, whose steps halve until they matter no more.
fn downhill(
    cost: &dyn Fn(&[f64]) -> f64,
    u: &[f64],
    c: f64,
    width: &[f64],
    finest: f64,
) -> (Vec<f64>, f64) {
    let (mut u, mut best) = (u.to_vec(), c);
    let mut width = width.to_vec();
    for _ in 0..16 {
        let mut moved = false;
        for i in 0..u.len() {
            for way in [-1.0, 1.0] {
                let mut tried = u.clone();
                tried[i] = (tried[i] + way * width[i]).clamp(0.0, 1.0);
                let c = cost(&tried);
                if c < best {
                    (u, best, moved) = (tried, c, true);
                    break;
                }
            }
        }
        if !moved {
            width.iter_mut().for_each(|w| *w *= 0.5);
        }
        if width.iter().all(|w| *w < finest) {
            break;
        }
    }
    (u, best)
}

/// By how much the amplitude of what acts once may be off 1.
pub const ONCE: f64 = 0.003;

/// Share of the cost by which the last step may be off from what it promised.
const SETTLED: f64 = 1e-4;

/// What came out of a fit: parameters, effects, cost.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The problem at its parameters.
    pub problem: Problem,
    /// The effects.
    pub effects: Vec<FittedEffect>,
}

/// Moves the declared parameters (and the amplitudes of `effects`, whose shapes stay) to their best, linear again and
/// again.
pub fn settle(
    problem: &Problem,
    base: &Base,
    noise: &Noise,
    effects: &[(Candidate, Vec<f64>)],
) -> Option<Solution> {
    let mut problem = problem.clone();
    // The specimen's answer is linear in its parameters but for effects relative to its stiffness, the actuator's
    // nearly.
    let rounds = match base.channel {
        plant::Channel::Specimen if effects.is_empty() && base.known.is_empty() => 1,
        plant::Channel::Specimen => 3,
        plant::Channel::Actuator => 5,
    };
    let mut promised = f64::INFINITY;
    let mut last = None;
    // The way to the declared parameters is shorter while what acts once may act a little more or less; in the end it acts
    // once, as it does in the model that is saved.
    let acts_once = |(c, _): &(Candidate, Vec<f64>)| {
        let bounds = (c.bounds)(&problem.scales);
        bounds.iter().any(Bound::is_once)
    };
    let exact_rounds = if effects.iter().any(acts_once) { 2 } else { 0 };
    for round in 0..rounds + exact_rounds {
        let mut frame = Frame::new(&problem, base, noise, effects);
        if round >= rounds {
            frame.act_once();
        }
        let found = frame.alone()?;
        let mut theta = problem.theta;
        for (f, change) in base.free.iter().zip(&found.values) {
            theta[f.index] += change;
        }
        problem.set(base, theta);
        let settled = (found.cost - promised).abs() < SETTLED * found.cost.max(1.0);
        promised = found.cost;
        last = Some(found);
        if settled && (exact_rounds == 0 || round >= rounds) {
            break;
        }
    }
    let found = last?;
    let mut amplitudes = found.values[base.free.len()..].iter();
    let fitted: Vec<FittedEffect> = effects
        .iter()
        .map(|(candidate, shapes)| FittedEffect {
            candidate: *candidate,
            shapes: shapes.clone(),
            amplitudes: amplitudes
                .by_ref()
                .take((candidate.bounds)(&problem.scales).len())
                .copied()
                .collect(),
        })
        .collect();
    Some(Solution {
        problem,
        effects: fitted,
    })
}
