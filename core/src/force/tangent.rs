//! Tangent force: corrects the restoring force for the travel that the specimen still lacks.
//!
//! Eq 14 is a force correction in disguise (see [`super::damping`]): `C_cor du/dt = -E/du`, the error `u_m - u_c` times
//! the specimen's secant. Here that is written down directly, `R = R_m + K_t (u_c - u_m)`, storey by storey, with `K_t`
//! the secant of the measured path over at least `delta` of motion. It needs no division by the command's increment, it
//! takes out gain errors as well as delays, and on a linear specimen it is exact whatever the actuator does.
//!
//! `K_t` starts at the declared `K_0`, is kept between 0 and `2 K_0`, and goes back to `K_0` where the specimen turns
//! round. Displacement and shear pass the same low-pass before the secant is formed, so that their lag cancels. While
//! the command has turned and the specimen has not, the remaining travel has two parts: on to the turning point with
//! `K_t`, and back from it with `K_0`.
//!
//! Parameters: `tangent.share`, `tangent.motion_m`, `tangent.smoothing_ms`. Cost: some 60 operations a storey.
//!
//! # When not to use it
//! Where the force does not depend on displacement (a viscous damper: use a predictor), or where the declared `K_0`
//! is not known to some tens of per cent. Yielding that is still ahead cannot be known: with 60 ms of delay it costs
//! 9 % without a predictor in front, and 1 % with one.

use super::interface::Correct;
use crate::config::Compensation;
use crate::context::Context;
use crate::energy::Observation;
use crate::float::{larger, smaller};
use crate::refusal::{Refusal, accept, between};
use crate::structure::{actuated, storey_stiffness};

/// Constants of the tangent force.
#[derive(Clone, Debug)]
pub(crate) struct Constants<const N: usize> {
    /// Initial stiffness of each storey of the specimen, N/m.
    pub initial_n_per_m: [f32; N],
    /// Shortest travel over which a secant is formed, m.
    pub least_motion_m: f32,
    /// The same as a fraction of the running peak drift.
    pub share: f32,
    /// Decay factor of the running peak per integration step.
    pub peak_memory: f32,
    /// Weight of a new value in the low-pass; 1 means no low-pass.
    pub smoothing: f32,
    /// Number of storeys in the laboratory.
    pub physical: usize,
}

/// The path of one storey.
#[derive(Clone, Copy, Debug)]
struct Path {
    /// Low-passed drift and shear.
    drift_m: f32,
    shear_n: f32,
    /// Where the present secant begins.
    from_m: f32,
    from_n: f32,
    /// Farthest point in the present direction.
    farthest_m: f32,
    farthest_n: f32,
    /// Farthest target in the present direction.
    turn_m: f32,
    /// Direction of the motion, 1 or -1; 0 before the first.
    direction: f32,
    peak_m: f32,
    tangent_n_per_m: f32,
}

/// Tangent forces of all storeys.
#[derive(Clone, Debug)]
pub(crate) struct TangentForce<const N: usize> {
    paths: [Path; N],
}

impl<const N: usize> Correct<N> for TangentForce<N> {
    type Constants = Constants<N>;

    fn check(c: &Compensation) -> Result<(), Refusal> {
        let t = &c.tangent;
        between(
            "compensation.tangent.motion_m",
            t.motion_m,
            0.0,
            1.0,
            "above 0 and below 1 m",
        )?;
        accept(
            "compensation.tangent.share",
            t.share,
            (0.0..1.0).contains(&t.share),
            "0 to below 1",
        )?;
        accept(
            "compensation.tangent.smoothing_ms",
            t.smoothing_ms,
            (0.0..=1e3).contains(&t.smoothing_ms),
            "0 to 1000 ms",
        )
    }

    fn design(context: &Context<'_, N>) -> Constants<N> {
        let t = &context.parameters.tangent;
        let step_ms = context.model_step_s * context.time_scale * 1e3;
        Constants {
            initial_n_per_m: storey_stiffness(&context.specimen_n_per_m).map(|k| k as f32),
            least_motion_m: t.motion_m as f32,
            share: t.share as f32,
            peak_memory: context.peak_memory(),
            smoothing: (1.0 - libm::exp(-step_ms / t.smoothing_ms)) as f32,
            physical: context.physical(),
        }
    }

    /// At rest at zero, with the declared stiffness.
    fn at_rest(k: &Constants<N>) -> Self {
        Self {
            paths: core::array::from_fn(|j| Path {
                drift_m: 0.0,
                shear_n: 0.0,
                from_m: 0.0,
                from_n: 0.0,
                farthest_m: 0.0,
                farthest_n: 0.0,
                turn_m: 0.0,
                direction: 0.0,
                peak_m: 0.0,
                tangent_n_per_m: k.initial_n_per_m[j],
            }),
        }
    }

    /// Forces by floor, from the measurements on the way to the target.
    #[inline]
    fn at_target(&mut self, k: &Constants<N>, now: &Observation<N>) -> [f32; N] {
        let mut force_n = now.force_n;
        let (mut shear_n, mut above_n) = (0.0, 0.0);
        for j in (0..actuated::<N>(k.physical)).rev() {
            // A floor's actuator carries the difference of two storey shears.
            shear_n += now.force_n[j];
            let below = j.checked_sub(1);
            let drift = |u: &[f32; N]| u[j] - below.map_or(0.0, |b| u[b]);
            let (measured_m, target_m) = (drift(&now.displacement_m), drift(&now.command_m));
            let correction_n =
                self.paths[j].correction(k, k.initial_n_per_m[j], measured_m, target_m, shear_n);
            force_n[j] += correction_n - above_n;
            above_n = correction_n;
        }
        force_n
    }
}

impl Path {
    #[inline]
    fn correction<const N: usize>(
        &mut self,
        k: &Constants<N>,
        initial_n_per_m: f32,
        measured_m: f32,
        target_m: f32,
        shear_n: f32,
    ) -> f32 {
        self.drift_m += k.smoothing * (measured_m - self.drift_m);
        self.shear_n += k.smoothing * (shear_n - self.shear_n);
        self.peak_m = larger(k.peak_memory * self.peak_m, self.drift_m.abs());
        let least_m = larger(k.least_motion_m, k.share * self.peak_m);

        let back_m = (self.farthest_m - self.drift_m) * self.direction;
        if self.direction == 0.0 || back_m > least_m {
            // Turned round: elastic again, from the farthest point.
            self.direction = 1.0_f32.copysign(self.drift_m - self.farthest_m);
            (self.from_m, self.from_n) = (self.farthest_m, self.farthest_n);
            self.turn_m = target_m;
            self.tangent_n_per_m = initial_n_per_m;
            (self.farthest_m, self.farthest_n) = (self.drift_m, self.shear_n);
        } else if back_m <= 0.0 {
            (self.farthest_m, self.farthest_n) = (self.drift_m, self.shear_n);
        }
        let way_m = self.drift_m - self.from_m;
        if way_m * self.direction > least_m {
            let secant = (self.shear_n - self.from_n) / way_m;
            if secant.is_finite() {
                self.tangent_n_per_m = smaller(larger(secant, 0.0), 2.0 * initial_n_per_m);
            }
            (self.from_m, self.from_n) = (self.drift_m, self.shear_n);
        }
        if (target_m - self.turn_m) * self.direction > 0.0 {
            self.turn_m = target_m;
        }
        // The way on from the farthest point, and back from it: elastic behind it, with K_t beyond it.
        let along = |at_m: f32| {
            let beyond_m = at_m - self.farthest_m;
            let elastic = beyond_m * self.direction < 0.0;
            beyond_m
                * if elastic {
                    initial_n_per_m
                } else {
                    self.tangent_n_per_m
                }
        };
        along(self.turn_m) + initial_n_per_m * (target_m - self.turn_m) - along(measured_m)
    }
}
