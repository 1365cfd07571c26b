//! The size of an effect: what is left of it after the declared parameters have moved as far as they may.

use crate::effect::Physics;
use crate::fine::rms;
use crate::rig::Scene;

/// How far from its declared value a parameter may be refitted, in tolerances.
const TOLERANCES: f64 = 3.0;
/// Only every eighth step of the fine grid is used, which gives 1 kHz.
const EVERY: usize = 8;

/// A declared parameter: how one tolerance of it changes the channel, and by how many tolerances it is wrong.
#[derive(Clone, Debug)]
pub(crate) struct Sensitivity {
    pub(crate) per_tolerance: Vec<f64>,
    pub(crate) off: f64,
}

impl Sensitivity {
    /// From the true signal and the one with the parameter one tolerance larger.
    pub(crate) fn new(truth: &[f64], more: &[f64], off: f64) -> Self {
        let per_tolerance = truth
            .iter()
            .zip(more)
            .step_by(EVERY)
            .map(|(a, b)| b - a)
            .collect();
        Self { per_tolerance, off }
    }
}

/// Rms of the part of `with - without` that the declared parameters cannot absorb, in the unit of the channel.
pub(crate) fn beyond_tolerance(without: &[f64], with: &[f64], free: &[Sensitivity]) -> f64 {
    let mut rest: Vec<f64> = without
        .iter()
        .zip(with)
        .step_by(EVERY)
        .map(|(a, b)| b - a)
        .collect();
    let norms: Vec<f64> = free
        .iter()
        .map(|s| s.per_tolerance.iter().map(|c| c * c).sum())
        .collect();
    let mut at = vec![0.0; free.len()];
    // Coordinate descent in a box; the columns are few and nearly orthogonal.
    for _ in 0..60 {
        let mut moved: f64 = 0.0;
        for (j, column) in free.iter().enumerate() {
            if norms[j] == 0.0 {
                continue;
            }
            let along: f64 = rest
                .iter()
                .zip(&column.per_tolerance)
                .map(|(r, c)| r * c)
                .sum();
            let next =
                (at[j] + along / norms[j]).clamp(-TOLERANCES - column.off, TOLERANCES - column.off);
            let step = next - at[j];
            at[j] = next;
            moved = moved.max(step.abs());
            for (r, c) in rest.iter_mut().zip(&column.per_tolerance) {
                *r -= step * c;
            }
        }
        if moved < 1e-3 {
            break;
        }
    }
    rms(&rest)
}

/// Weakest unusual strength, as a share of the weakest usual one.
const UNUSUAL: f64 = 0.02;

/// The strength at which the effect has the wanted size, and that size; the strongest plausible one if that is still too small.
/// Unless `usual`, strengths far below the range of the effect are tried, too.
pub(crate) fn strength_of(
    physics: &Physics,
    scene: &Scene,
    without: &[f64],
    free: &[Sensitivity],
    wanted: f64,
    usual: bool,
) -> (f64, f64) {
    let size =
        |strength: f64| beyond_tolerance(without, &(physics.apply)(strength, scene, without), free);
    let (mut weak, mut strong) = physics.range;
    let largest = size(strong);
    if largest <= wanted {
        return (strong, largest);
    }
    let rounds = if usual { 10 } else { 20 };
    if !usual {
        weak *= UNUSUAL;
    }
    for _ in 0..rounds {
        let middle = (weak * strong).sqrt();
        if size(middle) < wanted {
            weak = middle;
        } else {
            strong = middle;
        }
    }
    (strong, size(strong))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_parameter_may_explain_is_no_size() {
        let sine: Vec<f64> = (0..80_000).map(|i| (0.001 * f64::from(i)).sin()).collect();
        let scaled = |g: f64| sine.iter().map(|x| g * x).collect::<Vec<_>>();
        let free = [Sensitivity::new(&sine, &scaled(1.01), 1.0)];
        // The parameter is already wrong by one tolerance of 1 %, so it can absorb 2 % more; the rest of 5 % remains.
        assert!(beyond_tolerance(&sine, &scaled(1.02), &free) < 1e-9);
        let left = beyond_tolerance(&sine, &scaled(1.05), &free);
        assert!((left / (0.03 * rms(&sine)) - 1.0).abs() < 1e-3);
    }
}
