//! Force at the time at which the target was reached: Ahmadizadeh, Mosqueda and Reinhorn, EESD 37 (2008) 21.
//!
//! Quadratics are fitted to the last [`POINTS`] displacements and forces, by least squares. The time `t*` at which the
//! fitted displacement is at the target is found, and the measured force is moved along its own fit from now to `t*`.
//! In front of it the same authors extrapolate the command by a delay that is estimated on line: here
//! [`super::predict::darby`].
//!
//! Parameters: `hold_share`; those of `darby`. State 64 bytes a storey. Cost: two fits of 8 points and two Newton steps.
//!
//! # When not to use it
//! It looks at most [`REACH`] integration steps ahead or back, so the predictor must have brought the specimen near the
//! target; at a turning point, where no time belongs to a displacement, it does nothing. The fits are over 4 ms at
//! 2 kHz, too short against noise: filter first.

use crate::energy::Observation;
use crate::order::{larger, smaller};

/// Points of a fit.
pub const POINTS: usize = 8;

/// How far from now the target may have been or be reached, integration steps.
pub const REACH: f32 = 4.0;

/// Constants of the correction.
#[derive(Clone, Copy, Debug)]
pub struct Constants {
    /// Share of the running peak of the velocity below which nothing is corrected.
    pub hold_share: f32,
    /// What the running peak keeps from one integration step to the next.
    pub peak_memory: f32,
    /// Number of axes in the laboratory.
    pub physical: usize,
}

/// A quadratic `c0 + c1 t + c2 (t^2 - 5.25)`, `t` from -3.5 to 3.5 in steps.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Quadratic([f32; 3]);

/// Time of the newest point.
const NOW: f32 = 3.5;

/// Mean square of the times of the points: it makes the three terms orthogonal.
const MEAN_SQUARE: f32 = 5.25;

impl Quadratic {
    /// Least squares through `points`, a ring whose newest value is at `newest`.
    #[inline]
    fn through(points: &[f32; POINTS], newest: usize) -> Self {
        // Oldest first; pairs that lie symmetric to the middle, from the outside in.
        let point = |i: usize| points[(newest + 1 + i) % POINTS];
        let mut c = [0.0; 3];
        for i in 0..POINTS / 2 {
            let (old, new) = (point(i), point(POINTS - 1 - i));
            let t = NOW - i as f32;
            c[0] += new + old;
            c[1] += t * (new - old);
            c[2] += (t * t - MEAN_SQUARE) * (new + old);
        }
        Self([
            c[0] * (1.0 / 8.0),
            c[1] * (1.0 / 42.0),
            c[2] * (1.0 / 168.0),
        ])
    }

    #[inline]
    fn at(&self, t: f32) -> f32 {
        self.0[0] + self.0[1] * t + self.0[2] * (t * t - MEAN_SQUARE)
    }

    #[inline]
    fn slope(&self, t: f32) -> f32 {
        self.0[1] + 2.0 * self.0[2] * t
    }
}

/// One axis.
#[derive(Clone, Copy, Debug)]
struct Past {
    displacement_m: [f32; POINTS],
    force_n: [f32; POINTS],
    peak_speed_m: f32,
}

/// Fitted forces of all axes.
#[derive(Clone, Debug)]
pub struct FittedForce<const N: usize> {
    past: [Past; N],
    newest: usize,
}

impl<const N: usize> FittedForce<N> {
    /// At rest at zero.
    pub const fn at_rest() -> Self {
        Self {
            past: [Past {
                displacement_m: [0.0; POINTS],
                force_n: [0.0; POINTS],
                peak_speed_m: 0.0,
            }; N],
            newest: 0,
        }
    }

    /// Restoring force at the target, N.
    #[inline]
    pub fn at_target(&mut self, k: &Constants, now: &Observation<N>) -> [f32; N] {
        let mut force_n = now.force_n;
        let newest = (self.newest + 1) % POINTS;
        self.newest = newest;
        for j in 0..N.min(k.physical) {
            let past = &mut self.past[j];
            past.displacement_m[newest] = now.displacement_m[j];
            past.force_n[newest] = now.force_n[j];
            let moved = Quadratic::through(&past.displacement_m, newest);
            let speed_m = moved.slope(NOW).abs();
            past.peak_speed_m = larger(k.peak_memory * past.peak_speed_m, speed_m);
            if speed_m <= k.hold_share * past.peak_speed_m {
                continue;
            }
            // Newton's method for the time at which the fit, moved to the newest point, is at the target.
            let wanted_m = moved.at(NOW) + (now.command_m[j] - now.displacement_m[j]);
            let mut t = NOW;
            for _ in 0..2 {
                let step = (wanted_m - moved.at(t)) / moved.slope(t);
                t = larger(smaller(t + step, NOW + REACH), NOW - REACH);
            }
            let pulled = Quadratic::through(&past.force_n, newest);
            let change_n = pulled.at(t) - pulled.at(NOW);
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
        for (i, point) in points.iter_mut().enumerate() {
            *point = y(i as f32 - 5.0);
        }
        points.rotate_right(3);
        // The newest stood at the end before the ring was turned.
        let fit = Quadratic::through(&points, 2);
        for t in [-3.5, 0.0, 3.5, 6.0] {
            assert!((fit.at(t) - y(t - 1.5)).abs() < 1e-5, "{t}");
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
            (FittedForce::<1>::at_rest(), 0.0_f32, 0.0_f32);
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
