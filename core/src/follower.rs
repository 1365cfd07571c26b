//! External targets, sample by sample: for a numerical part other than core's own.
//!
//! ```text
//!  numerical part ─► target ─►(+)─► differences ─► ahead ─► predictor ─► command
//!                              ▲
//!             copy of the numerical part ◄── correction of the force
//! ```
//!
//! A target that is known only when it is due is a control step too late for core, whose command is for the end of the
//! period. So the motion is extrapolated by a step, with the fourth-order polynomial through the last five targets,
//! which also gives velocity and acceleration.
//!
//! A compensation that acts in the equation of motion cannot reach an external numerical part. It acts on the declared
//! copy of it instead, and the copy's response is added to the target: both are linear, so the specimen is sent where
//! it would have been sent.

use crate::design::{Design, StepConstants};
use crate::energy::{EnergyErrors, Observation};
use crate::force::{Correction, Law, LawInput, LawOutput};
use crate::newmark::Newmark;
use crate::predict::{LastCommand, Predictor, TargetMotion};
use crate::structure::actuated;

/// Number of differences kept: the polynomial's order.
const ORDER: usize = 4;

/// Extrapolation of an axis's last targets: Newton's backward form.
#[derive(Clone, Copy, Debug, Default)]
struct Course {
    /// The target and its backward differences.
    differences: [f32; ORDER + 1],
}

/// Weights of the differences in the value and first two derivatives some control steps ahead.
#[derive(Clone, Copy, Debug)]
struct Weights {
    displacement: [f32; ORDER],
    velocity: [f32; ORDER - 1],
    acceleration: [f32; ORDER - 2],
}

impl Weights {
    /// `h` control steps ahead.
    #[inline]
    fn ahead(h: f32) -> Self {
        let (h2, h3) = (h * h, h * h * h);
        Self {
            displacement: [
                h,
                (h2 + h) * (1.0 / 2.0),
                (h3 + 3.0 * h2 + 2.0 * h) * (1.0 / 6.0),
                (h2 * h2 + 6.0 * h3 + 11.0 * h2 + 6.0 * h) * (1.0 / 24.0),
            ],
            velocity: [
                (2.0 * h + 1.0) * (1.0 / 2.0),
                (3.0 * h2 + 6.0 * h + 2.0) * (1.0 / 6.0),
                (4.0 * h3 + 18.0 * h2 + 22.0 * h + 6.0) * (1.0 / 24.0),
            ],
            acceleration: [h + 1.0, (12.0 * h2 + 36.0 * h + 22.0) * (1.0 / 24.0)],
        }
    }
}

impl Course {
    #[inline]
    fn append(&mut self, target_m: f32) {
        let mut new = target_m;
        for difference in &mut self.differences {
            let old = *difference;
            *difference = new;
            new -= old;
        }
    }

    /// Value, first and second derivative at the time that `weights` are for.
    #[inline]
    fn ahead(&self, weights: &Weights) -> TargetMotion {
        let [u, d1, d2, d3, d4] = self.differences;
        let Weights {
            displacement: x,
            velocity: v,
            acceleration: a,
        } = weights;
        TargetMotion {
            displacement_m: u + x[0] * d1 + x[1] * d2 + x[2] * d3 + x[3] * d4,
            velocity_m: d1 + v[0] * d2 + v[1] * d3 + v[2] * d4,
            acceleration_m: d2 + a[0] * d3 + a[1] * d4,
        }
    }
}

/// The compensation of a test with external targets.
///
/// ```
/// use outerloop_core::{Config, Design, Follower, Method};
///
/// let mut config = Config::shear_frame([1000.0], [158e3], [0.02]);
/// config.compensation.kind = Method::Afp; // behind a delay of 4 ms, 8 steps
/// let mut follower = Follower::<1>::new(Design::new(&config)?, 0.0);
/// let mut command_m = 0.0;
/// for step in 0..100 {
///     let target_m = 1e-5 * step as f32;
///     command_m = follower.step([target_m], [target_m], [158e3 * target_m])[0];
/// }
/// assert!(command_m > 1e-5 * 105.0, "it is sent ahead");
/// # Ok::<(), outerloop_core::Refusal>(())
/// ```
#[derive(Clone, Debug)]
pub struct Follower<const N: usize> {
    design: StepConstants<N>,
    law: Law<N>,
    /// The law's last action, used only by laws.
    shown: Correction<N>,
    predictor: Predictor<N>,
    energy: EnergyErrors<N>,
    /// Copy of the numerical part, moved by what is corrected of the force alone.
    copy: Newmark<N>,
    /// Delay, in control steps, with which the numerical part gets the force.
    late_steps: f32,
    /// True if the copy of the numerical part has a force to respond to.
    corrects: bool,
    /// Axes whose motion is followed: those with an actuator, or all if the predictor uses all.
    followed: usize,
    course: [Course; N],
    /// Of the course, to the time that a command is for.
    weights: Weights,
    /// Target that the last command was for, and that command, m.
    aim_m: [f32; N],
    sent_m: [f32; N],
}

impl<const N: usize> Follower<N> {
    /// At rest. `late_steps` is the delay, in control steps, with which the force reaches the numerical part, including
    /// half of the step for which it is held there; 0 corrects nothing.
    pub fn new(design: Design<N>, late_steps: f32) -> Self {
        let Design {
            step,
            law,
            predictor,
            ..
        } = design;
        Self {
            energy: EnergyErrors::new(step.specimen_stiffness, usize::from(step.window_steps)),
            copy: Newmark::at_rest(),
            late_steps,
            corrects: late_steps != 0.0 || !matches!(law, Law::None(..)),
            law,
            shown: Correction::NONE,
            followed: if predictor.sees_all() {
                N
            } else {
                actuated::<N>(step.physical)
            },
            predictor,
            course: [Course::default(); N],
            weights: Weights::ahead(1.0 + step.lead_steps),
            aim_m: [0.0; N],
            sent_m: [0.0; N],
            design: step,
        }
    }

    /// One control step: the target of this sample, what was measured at it (displacement, m; force, N), and the command
    /// until the next sample, m. Axes without an actuator return their target.
    #[inline(never)]
    pub fn step(
        &mut self,
        target_m: [f32; N],
        displacement_m: [f32; N],
        force_n: [f32; N],
    ) -> [f32; N] {
        let mut target_m = target_m;
        if self.corrects {
            let moved = self.copy.displacement_m();
            for j in 0..N {
                target_m[j] += moved[j];
            }
        }
        for j in 0..self.followed.min(N) {
            self.course[j].append(target_m[j]);
        }
        if self.corrects {
            let correction_n = self.correction(target_m, displacement_m, force_n);
            self.copy
                .advance(&self.design.newmark, &[0.0; N], &correction_n, &[0.0; N]);
        }
        let k = &self.design;
        let (mut followed, mut ahead) = ([LastCommand::AT_REST; N], [TargetMotion::AT_REST; N]);
        let mut send_m = target_m;
        for j in 0..self.followed.min(N) {
            followed[j] = LastCommand {
                target_m: self.aim_m[j],
                sent_m: self.sent_m[j],
                measured_m: displacement_m[j],
                learn: true,
            };
            ahead[j] = self.course[j].ahead(&self.weights);
            self.aim_m[j] = ahead[j].displacement_m;
            send_m[j] = self.aim_m[j];
        }
        self.predictor
            .command(&followed, &ahead, k.physical, &mut send_m);
        let mut command_m = target_m;
        for j in 0..actuated::<N>(k.physical) {
            if send_m[j].is_finite() {
                self.sent_m[j] = send_m[j];
            }
            command_m[j] = k.command[j].towards(self.sent_m[j]);
        }
        command_m
    }

    /// The correction of the force, N.
    #[inline]
    fn correction(
        &mut self,
        target_m: [f32; N],
        displacement_m: [f32; N],
        force_n: [f32; N],
    ) -> [f32; N] {
        let k = &self.design;
        let physical = actuated::<N>(k.physical);
        let here = Weights::ahead(0.0);
        let (mut velocity_dt_m, mut increment_m) = ([0.0; N], [0.0; N]);
        for j in 0..physical {
            velocity_dt_m[j] = self.course[j].ahead(&here).velocity_m;
            increment_m[j] = self.course[j].differences[1];
        }
        let mut correction_n = [0.0; N];
        if !matches!(self.law, Law::None(..)) {
            let now = Observation {
                command_m: target_m,
                increment_m,
                displacement_m,
                force_n,
            };
            let energy = self.energy.update(&now, k.physical);
            let reached = LawInput {
                now: &now,
                energy: &energy,
                velocity_dt_m,
                predictor_velocity_dt_m: velocity_dt_m,
            };
            let LawOutput {
                force_n: acting_n,
                damping,
            } = self.law.act(&reached, &mut self.shown);
            for j in 0..physical {
                let added_n = damping[j] * velocity_dt_m[j] * k.newmark.rate_hz;
                correction_n[j] = acting_n[j] - force_n[j] + added_n;
            }
        }
        for i in 0..physical {
            for j in 0..physical {
                correction_n[i] += self.late_steps * k.specimen_stiffness[i][j] * velocity_dt_m[j];
            }
        }
        correction_n
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_course_of_a_quartic_is_exact() {
        let p = |t: f32| 1.0 + t * (0.5 + t * (-0.25 + t * (0.125 - 0.0625 * t)));
        let slope = |t: f32| 0.5 + t * (-0.5 + t * (0.375 - 0.25 * t));
        let bend = |t: f32| -0.5 + t * (0.75 - 0.75 * t);
        let mut course = Course::default();
        for i in -4_i16..=0 {
            course.append(p(f32::from(i)));
        }
        for steps in [0.0, 1.0, 1.5, 2.0] {
            let ahead = course.ahead(&Weights::ahead(steps));
            for (found, exact) in [
                (ahead.displacement_m, p(steps)),
                (ahead.velocity_m, slope(steps)),
                (ahead.acceleration_m, bend(steps)),
            ] {
                assert!(
                    (found - exact).abs() < 1e-4 * (1.0 + exact.abs()),
                    "{found} {exact}"
                );
            }
        }
    }
}
