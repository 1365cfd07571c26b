//! Force at the time at which the target was reached: Ahmadizadeh, Mosqueda and Reinhorn, EESD 37 (2008) 21.
//!
//! Quadratics are fitted to the last [`POINTS`] displacements and forces, by least squares. The time at which the fitted
//! displacement is at the target is found, and the measured force is moved along its own fit from now to that time.
//! In front of it the same authors send the motion one delay ahead, by the equations of the integration, with a delay and
//! a command gain that are estimated on line: here [`crate::predict::afp`], which does that. They find the delay from
//! polynomials through desired and measured displacements; here the integration knows the velocity of the desired one,
//! so that what is left of the delay is the error over that velocity, without a fit.
//!
//! Parameters: `hold_share`; those of `afp`. State 68 bytes a storey. Cost: two fits of 8 points and two Newton steps.
//!
//! # When not to use it
//! It looks at most [`REACH`] integration steps ahead or back, so the predictor must have brought the specimen near the
//! target; at a turning point, where no time belongs to a displacement, it does nothing. The fits are over 4 ms at
//! 2 kHz, too short against noise: filter first.

use super::interface::Correct;
use crate::context::Context;
use crate::energy::Observation;
use crate::float::{larger, smaller};
use crate::structure::actuated;

/// Points of a fit.
const POINTS: usize = 8;

/// Longest time between now and the reaching of the target, before or after, integration steps.
const REACH: f32 = 4.0;

/// Constants of the correction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    /// Fraction of the running peak velocity below which nothing is corrected.
    pub hold_share: f32,
    /// Decay factor of the running peak per integration step.
    pub peak_memory: f32,
    /// Number of axes in the laboratory.
    pub physical: usize,
}

/// A fitted quadratic relative to its newest point: `slope h + bend h^2` in `h` steps.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FittedQuadratic {
    slope: f32,
    bend: f32,
}

impl FittedQuadratic {
    /// Least squares through `points`, oldest first.
    ///
    /// With times `t` from -3.5 to 3.5 the terms 1, t and t^2 - 5.25 are orthogonal, so each factor is a sum of its own
    /// over pairs that lie symmetric to the middle.
    #[inline]
    fn of(points: &[f32; POINTS]) -> Self {
        let [a, b, c, d, e, f, g, h] = *points;
        let rise = 3.5 * (h - a) + 2.5 * (g - b) + 1.5 * (f - c) + 0.5 * (e - d);
        let bend = 7.0 * (h + a) + (g + b) - 3.0 * (f + c) - 5.0 * (e + d);
        let bend = bend * (1.0 / 168.0);
        Self {
            slope: rise * (1.0 / 42.0) + 7.0 * bend,
            bend,
        }
    }

    /// Its change in `h` steps.
    #[inline]
    fn gain(&self, h: f32) -> f32 {
        h * (self.slope + self.bend * h)
    }
}

/// Takes the newest value into `points`, oldest first.
#[inline]
fn push(points: &mut [f32; POINTS], newest: f32) {
    let [_, b, c, d, e, f, g, h] = *points;
    *points = [b, c, d, e, f, g, h, newest];
}

/// The last samples of one axis.
#[derive(Clone, Copy, Debug)]
struct LastSamples {
    displacement_m: [f32; POINTS],
    force_n: [f32; POINTS],
    peak_speed_m: f32,
}

/// Fitted forces of all axes.
#[derive(Clone, Debug)]
pub(crate) struct FittedForce<const N: usize> {
    last: [LastSamples; N],
}

impl<const N: usize> Correct<N> for FittedForce<N> {
    type Constants = Constants;

    fn design(context: &Context<'_, N>) -> Constants {
        Constants {
            hold_share: context.parameters.hold_share as f32,
            peak_memory: context.peak_memory(),
            physical: context.physical(),
        }
    }

    fn at_rest(_: &Constants) -> Self {
        Self {
            last: [LastSamples {
                displacement_m: [0.0; POINTS],
                force_n: [0.0; POINTS],
                peak_speed_m: 0.0,
            }; N],
        }
    }

    #[inline]
    fn at_target(&mut self, k: &Constants, now: &Observation<N>) -> [f32; N] {
        let mut force_n = now.force_n;
        for j in 0..actuated::<N>(k.physical) {
            let last = &mut self.last[j];
            push(&mut last.displacement_m, now.displacement_m[j]);
            push(&mut last.force_n, now.force_n[j]);
            let moving = FittedQuadratic::of(&last.displacement_m);
            let speed_m = moving.slope.abs();
            last.peak_speed_m = larger(k.peak_memory * last.peak_speed_m, speed_m);
            if speed_m <= k.hold_share * last.peak_speed_m {
                continue;
            }
            // Newton's method for the time at which the fit, moved to the newest point, is at the target.
            let way_m = now.command_m[j] - now.displacement_m[j];
            let within = |h: f32| larger(smaller(h, REACH), -REACH);
            let first = within(way_m / moving.slope);
            let speed_m = moving.slope + 2.0 * moving.bend * first;
            let reached = within(first + (way_m - moving.gain(first)) / speed_m);
            let change_n = FittedQuadratic::of(&last.force_n).gain(reached);
            if change_n.is_finite() {
                force_n[j] += change_n;
            }
        }
        force_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_fitted_exactly() {
        let y = |t: f32| 2.0 - 0.5 * t + 0.25 * t * t;
        let mut points = [0.0; POINTS];
        for i in 0..12 {
            push(&mut points, y(i as f32 - 11.0));
        }
        let going = FittedQuadratic::of(&points);
        for h in [-7.0, -3.5, 0.0, 2.5, 6.0] {
            assert!((going.gain(h) - (y(h) - y(0.0))).abs() < 1e-5, "{h}");
        }
    }

    /// Against the normal equations of least squares, solved by another way: the residual is orthogonal to 1, t and t^2.
    #[test]
    fn what_is_no_quadratic_is_fitted_by_least_squares() {
        let points = [0.3, -1.2, 0.8, 2.5, -0.7, 1.1, 0.0, -2.0_f32];
        let FittedQuadratic { slope, bend } = FittedQuadratic::of(&points);
        let fitted = |t: f32| slope * (t - 7.0) + bend * (t - 7.0) * (t - 7.0);
        let rest = |i: usize| points[i] - fitted(i as f32);
        let mean = (0..POINTS).map(rest).sum::<f32>() / POINTS as f32;
        for power in 1..=2 {
            let product: f32 = (0..POINTS)
                .map(|i| (rest(i) - mean) * (i as f32).powi(power))
                .sum();
            assert!(product.abs() < 1e-4, "{power}: {product}");
        }
    }

    #[test]
    fn the_force_of_a_hardening_specimen_is_that_at_the_target() {
        let k = Constants {
            hold_share: 0.05,
            peak_memory: 0.999,
            physical: 1,
        };
        let spring = |u: f32| 1e5 * u + 1e8 * u * u * u;
        let (mut stage, mut worst, mut uncorrected) =
            (FittedForce::<1>::at_rest(&k), 0.0_f32, 0.0_f32);
        for i in 0..2000 {
            let at = |steps: f32| 0.02 * libm::sinf(0.0063 * steps);
            let (target, moved) = (at(i as f32), at(i as f32 - 2.0));
            let now = Observation {
                command_m: [target],
                increment_m: [0.0],
                displacement_m: [moved],
                force_n: [spring(moved)],
            };
            let force_n = stage.at_target(&k, &now)[0];
            if i > 20 && libm::cosf(0.0063 * i as f32).abs() > 0.1 {
                worst = worst.max((force_n - spring(target)).abs());
                uncorrected = uncorrected.max((spring(moved) - spring(target)).abs());
            }
        }
        assert!(worst < 0.02 * uncorrected, "{worst} of {uncorrected}");
    }
}
