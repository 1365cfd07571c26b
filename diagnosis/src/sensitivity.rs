//! How the answer of a model with effects changes with everything that was fitted.

use crate::base::Base;
use crate::fit::{ONCE, Solution};
use crate::library::candidate::Candidate;
use crate::linear::{Bound, Normal, dot, gram, solve};
use crate::noise::Noise;
use crate::problem::{FittedEffect, Problem};
use crate::signals::{difference, difference_quotient};
use nalgebra::DVector;
use plant::Channel;
use std::borrow::Cow;

/// An unknown of an effect.
#[derive(Clone, Copy, Debug)]
pub struct EffectUnknown {
    /// Which of the solution's effects.
    pub effect: usize,
    /// An amplitude, else a shape.
    pub amplitude: bool,
    /// Which of them.
    pub index: usize,
}

impl EffectUnknown {
    /// The effects with this unknown moved a little, and by how much.
    pub fn moved(&self, effects: &[FittedEffect]) -> (Vec<FittedEffect>, f64) {
        let mut moved = effects.to_vec();
        let e = &mut moved[self.effect];
        let value = if self.amplitude {
            &mut e.amplitudes[self.index]
        } else {
            &mut e.shapes[self.index]
        };
        let step = 2e-3 * value.abs().max(1e-9);
        *value += step;
        (moved, step)
    }
}

/// Amplitudes, then shapes, of one effect.
pub fn unknowns(effect: usize, e: &FittedEffect) -> Vec<EffectUnknown> {
    let of = |amplitude: bool, n: usize| {
        (0..n).map(move |index| EffectUnknown {
            effect,
            amplitude,
            index,
        })
    };
    of(true, e.amplitudes.len())
        .chain(of(false, e.shapes.len()))
        .collect()
}

/// Derivatives of the white answer, and the white residual.
#[derive(Clone, Debug)]
pub struct Jacobian {
    /// Declared parameters that are free, then the unknowns of each effect.
    pub columns: Vec<Vec<f64>>,
    /// Measured less modelled.
    pub residual: Vec<f64>,
    /// What is known beforehand.
    pub known: Vec<Prior>,
}

/// What is known of an unknown beforehand.
#[derive(Clone, Copy, Debug)]
pub struct Prior {
    /// Which column.
    pub index: usize,
    /// One over its variance.
    pub precision: f64,
    /// Expected value less the present one.
    pub off: f64,
}

impl Jacobian {
    /// At a solution.
    pub fn of(solution: &Solution, base: &Base, noise: &Noise) -> Self {
        let (problem, scales) = (&solution.problem, solution.problem.scales);
        let all = every(solution);
        let stages: Vec<(Candidate, &[f64])> = solution
            .effects
            .iter()
            .map(|e| (e.candidate, e.shapes.as_slice()))
            .collect();
        let n = base.free.len() + all.len();
        let (mut columns, mut white) = (vec![Vec::new(); n], Vec::new());
        // The noise of a reading is late by whole samples: a small step that takes it over to the next one is no derivative.
        let late = stages.iter().any(|(c, _)| c.stage.is_some());
        let smooth = match base.channel {
            Channel::Specimen if late => Cow::Owned(without_noise(problem, base)),
            _ => Cow::Borrowed(problem),
        };
        for (segment, motion) in problem.segments.iter().zip(&smooth.segments) {
            let mut raw = problem.staged_columns(base, segment, &stages);
            let from = smooth.answer(motion, &solution.effects, &scales);
            for unknown in &all {
                let (moved, step) = unknown.moved(&solution.effects);
                let there = smooth.answer(motion, &moved, &scales);
                raw.push(difference_quotient(&there, &from, step));
            }
            let here = problem.answer(segment, &solution.effects, &scales);
            for (raw, column) in raw.into_iter().zip(&mut columns) {
                noise.whiten_into(&segment.judged(&raw), column);
            }
            let residual = difference(&segment.target, &here);
            noise.whiten_into(&segment.judged(&residual), &mut white);
        }
        Self {
            columns,
            residual: white,
            known: priors(solution, base),
        }
    }
}

/// The same with a displacement that is read without noise.
fn without_noise(problem: &Problem, base: &Base) -> Problem {
    let mut smooth = problem.clone();
    for segment in &mut smooth.segments {
        segment.signals.reading = segment.signals.x.clone();
    }
    smooth.set(base, problem.theta);
    smooth
}

fn priors(solution: &Solution, base: &Base) -> Vec<Prior> {
    let theta = &solution.problem.theta;
    let declared = base.free.iter().enumerate().map(|(index, f)| Prior {
        index,
        precision: f.tolerance.powi(-2),
        off: base.values[f.index] - theta[f.index],
    });
    let mut priors: Vec<Prior> = declared.collect();
    let mut at = base.free.len();
    for e in &solution.effects {
        let bounds = (e.candidate.bounds)(&solution.problem.scales);
        for (i, (bound, amplitude)) in bounds.iter().zip(&e.amplitudes).enumerate() {
            if bound.is_once() {
                priors.push(Prior {
                    index: at + i,
                    precision: ONCE.powi(-2),
                    off: 1.0 - amplitude,
                });
            }
        }
        at += e.amplitudes.len() + e.shapes.len();
    }
    priors
}

fn every(solution: &Solution) -> Vec<EffectUnknown> {
    let effects = solution.effects.iter().enumerate();
    effects.flat_map(|(i, e)| unknowns(i, e)).collect()
}

/// Where everything together would be best if the answer were linear: the change of each effect's shapes.
pub fn step(solution: &Solution, base: &Base, noise: &Noise) -> Option<Vec<Vec<f64>>> {
    let Jacobian {
        columns,
        residual,
        known,
    } = Jacobian::of(solution, base, noise);
    let n = columns.len();
    let mut matrix = gram(&columns);
    let mut right = DVector::from_fn(n, |i, _| dot(&columns[i], &residual));
    for p in &known {
        matrix[(p.index, p.index)] += p.precision;
        right[p.index] += p.precision * p.off;
    }
    let scales = solution.problem.scales;
    let mut bounds = base.bounds(&solution.problem.theta);
    for e in &solution.effects {
        let around = |b: Bound, value: f64| Bound {
            low: (b.low - value).min(0.0),
            high: (b.high - value).max(0.0),
        };
        let own = (e.candidate.bounds)(&scales);
        bounds.extend(
            own.into_iter()
                .zip(&e.amplitudes)
                .map(|(b, a)| around(b, *a)),
        );
        let shapes = (e.candidate.shapes)(&scales);
        bounds.extend(shapes.iter().zip(&e.shapes).map(|(s, v)| {
            let (low, high) = (s.low, s.high);
            around(Bound { low, high }, *v)
        }));
    }
    let square = dot(&residual, &residual);
    let normal = Normal {
        matrix,
        right,
        square,
    };
    let (x, _) = solve(&normal, &bounds)?;
    let mut at = base.free.len();
    let shapes = solution.effects.iter().map(|e| {
        at += e.amplitudes.len();
        let step = x.as_slice()[at..at + e.shapes.len()].to_vec();
        at += e.shapes.len();
        step
    });
    Some(shapes.collect())
}
