//! The next target while the loop runs no test of its own.

use super::OuterLoop;
use crate::float::{larger, smaller};
use crate::record::flag;
use crate::rig::Rig;
use crate::signal::SignalGenerator;
use crate::supervise::Mode;

/// Displacement by which a ramp must have stopped, as a fraction of the displacement limit.
const BEFORE_LIMIT: f32 = 0.98;

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// The next target in every mode except a test of the loop's own, which the step itself handles.
    #[cold] // The step of a test of its own, the longest, then runs straight on.
    #[inline(never)]
    pub(super) fn command_without_integration(
        &mut self,
        displacement_m: &[f32; N],
        chain_open: bool,
    ) -> [f32; N] {
        match self.mode {
            Mode::Idle => self.follow(displacement_m),
            Mode::Approaching if chain_open => {
                self.flags |= flag::CHAIN_OPEN;
                match self.idle_mean_m {
                    // Permitted but unable to move yet: follow it, as while idle.
                    Some(_) => self.follow(displacement_m),
                    // The contact bounces during the approach.
                    None => self.target_m,
                }
            }
            Mode::Approaching => self.approach_start(),
            Mode::Armed => [0.0; N],
            Mode::Running | Mode::Resuming => self.go_to_next_target(),
            Mode::Returning => self.return_to_target(),
            Mode::Commissioning => self.follow_commissioning_signal(),
            Mode::Holding | Mode::Finished => self.slow_down(),
            Mode::Stopping => self.stop_on_fault(),
            Mode::Tripped => self.aimed_m,
        }
    }

    /// Idle: the target follows the true position and the command holds the actuator there, so that arming moves
    /// nothing, however well offsets and gains are known.
    fn follow(&mut self, displacement_m: &[f32; N]) -> [f32; N] {
        let idle_share = self.design.idle_share;
        let mut idle_mean_m = self.idle_mean_m.unwrap_or(*displacement_m);
        for (mean, &new) in idle_mean_m.iter_mut().zip(displacement_m) {
            // A running mean, so that noise causes no jump.
            let moved = *mean + (new - *mean) * idle_share;
            *mean = if moved.is_finite() { moved } else { 0.0 };
        }
        // Without a fresh sample the actuator's position is unknown, and arming is not possible.
        if self.idle_mean_m.is_some() || self.flags & flag::STALE == 0 {
            self.idle_mean_m = Some(idle_mean_m);
        }
        idle_mean_m
    }

    /// A step of the slow approach to the start position.
    fn approach_start(&mut self) -> [f32; N] {
        // It leaves the position at which it was armed.
        self.idle_mean_m = None;
        let next_m = self.approach([0.0; N]);
        if next_m == [0.0; N] {
            self.mode = Mode::Armed;
        }
        next_m
    }

    /// A step of the slow approach to `commissioning_m`.
    pub(super) fn approach(&self, commissioning_m: [f32; N]) -> [f32; N] {
        core::array::from_fn(|j| {
            let step = self.design.approach_step_m * self.rig.per_metre(j);
            let rest = commissioning_m[j] - self.target_m[j];
            if rest.abs() <= step {
                commissioning_m[j]
            } else {
                self.target_m[j] + step.copysign(rest)
            }
        })
    }

    /// After a hold: a step of the slow return to the target at which the test paused.
    fn return_to_target(&mut self) -> [f32; N] {
        let target_m = self.newmark.displacement_m();
        let next_m = self.approach(target_m);
        // A hold on the way begins at the present command.
        self.signal.follow(next_m);
        if self.target_m == target_m {
            self.signal = SignalGenerator::standing_at(target_m);
            self.resume_share = 0.0;
            self.mode = if self.design.predicts {
                Mode::Resuming
            } else {
                Mode::Running
            };
        }
        next_m
    }

    /// A commissioning signal replaces the test: the command follows it.
    fn follow_commissioning_signal(&mut self) -> [f32; N] {
        self.signal.follow(self.commissioning_m);
        self.commissioning_m
    }

    /// The record has ended.
    #[cold]
    #[inline(never)]
    pub(super) fn finish(&mut self) {
        self.stop_at_command();
        self.mode = Mode::Finished;
    }

    /// A step of the ramp after a non-emergency fault; PERMIT is withdrawn at its end.
    fn stop_on_fault(&mut self) -> [f32; N] {
        let next_m = self.slow_down();
        if *self.signal.velocity_m() == [0.0; N] {
            self.mode = Mode::Tripped;
        }
        next_m
    }

    /// False if the ramp would take too long to be a way of ending a test: a command that runs away or is NaN is
    /// stopped at once.
    pub(super) fn stops_soon(&self) -> bool {
        let longest_m = self.design.deceleration_step_m * self.design.longest_ramp_steps;
        let velocity_m = self.signal.velocity_m();
        (0..N).all(|j| velocity_m[j].abs() <= longest_m * self.rig.per_metre(j))
    }

    /// A step of the ramp to hold: the command's velocity goes to zero at the set deceleration, or at a larger one
    /// where that is needed to stop every actuator before its displacement limit.
    fn slow_down(&mut self) -> [f32; N] {
        let (at_m, velocity_m) = (*self.signal.command_m(), *self.signal.velocity_m());
        let share = self.least_share(&at_m, &velocity_m);
        let step_m = self.design.deceleration_step_m;
        let by = core::array::from_fn(|j| {
            larger(step_m * self.rig.per_metre(j), share * velocity_m[j].abs())
        });
        self.signal.decelerate(by);
        *self.signal.command_m()
    }

    /// The fraction of its velocity that the motion must lose in this step: v / 2s, with s the distance left to the
    /// limit of the worst actuator.
    fn least_share(&self, at_m: &[f32; N], velocity_m: &[f32; N]) -> f32 {
        let next_m = core::array::from_fn(|j| at_m[j] + velocity_m[j]);
        let mut places = [[0.0; N]; 2];
        let [here, there] = &mut places;
        let (from_m, to_m) = (self.strokes_m(at_m, here), self.strokes_m(&next_m, there));
        let limit_m = BEFORE_LIMIT * self.design.limits.displacement_m;
        let strokes_m = from_m.iter().zip(to_m).take(self.design.physical);
        let shares = strokes_m.map(|(from_m, to_m)| {
            let step_m = to_m - from_m;
            let left_m = limit_m - from_m * 1.0_f32.copysign(step_m);
            match step_m != 0.0 && left_m <= 0.0 {
                true => 1.0,
                false => step_m.abs() / (2.0 * left_m),
            }
        });
        smaller(shares.fold(0.0, larger), 1.0)
    }
}
