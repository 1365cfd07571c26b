//! From target to command: prediction, interlocks, and sending.

use super::{OuterLoop, Pace, Sample};
use crate::float::unlikely;
use crate::ground_motion::GroundMotion;
use crate::predict::{LastCommand, TargetMotion};
use crate::record::flag;
use crate::rig::{Asked, Rig};
use crate::supervise::{Checked, Event, Fault, Finding, Mode, Trip, first_fault, within};

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// The command for the target `next_m`: the predictor's output while the test runs, else the target itself. The
    /// predictor sees every step, so that its memory reflects what really happened.
    #[inline]
    pub(super) fn predict(
        &mut self,
        measured_m: [f32; N],
        next_m: [f32; N],
        usable: bool,
    ) -> [f32; N] {
        let held = self.post.flags() & flag::GUARDED != 0;
        if held {
            self.unlearn_held();
        }
        let k = &self.design;
        let live = self.mode.integrates() && self.pace != Some(Pace::StopAndGo);
        let (velocity_m, acceleration_m) = if live {
            let signal = &self.signal;
            (*signal.velocity_m(), signal.acceleration_m(&k.signal))
        } else {
            unlikely(([0.0; N], [0.0; N]))
        };
        let adjusted = self.post.flags() & flag::ADJUSTED != 0;
        let followed = core::array::from_fn(|j| LastCommand {
            target_m: self.target_m[j] + self.lead_m[j],
            sent_m: self.aimed_m[j],
            measured_m: measured_m[j],
            // If only part of the prediction is sent, the shortfall is not a delay to learn from.
            learn: live
                && usable
                && self.mode != Mode::Resuming
                && !(held && self.post.axis(j).hold),
        });
        let mut ahead: [TargetMotion; N] = core::array::from_fn(|j| TargetMotion {
            displacement_m: next_m[j],
            velocity_m: velocity_m[j],
            acceleration_m: acceleration_m[j],
        });
        let mut send_m = next_m;
        if k.lead_steps != 0.0 || adjusted {
            // Numerical degrees of freedom go exactly to their targets.
            for j in 0..N {
                let motion = ahead[j].led_by(k.lead_steps);
                let follows = &mut self.lead_acceleration_m[j];
                *follows += k.lead_follows * (motion.acceleration_m - *follows);
                ahead[j] = motion.led_at(self.post.axis(j).lead_steps, *follows);
                self.lead_m[j] = ahead[j].displacement_m - next_m[j];
                if j < k.physical {
                    send_m[j] = ahead[j].displacement_m;
                }
            }
        }
        self.predictor
            .command(&followed, &ahead, k.physical, &mut send_m);
        if !live {
            return next_m;
        }
        if self.mode == Mode::Resuming {
            for j in 0..N {
                send_m[j] = next_m[j] + self.resume_share * (send_m[j] - next_m[j]);
            }
            self.resume_share += k.resume_step;
            if self.resume_share >= 1.0 {
                self.mode = Mode::Running;
            }
        }
        send_m
    }

    /// The commands that bring the structure to `aim_m`.
    #[inline]
    pub(super) fn commands(&mut self, aim_m: &[f32; N], ground: &GroundMotion<'_>) -> [f32; N] {
        let asked = Asked {
            aim_m,
            sent_m: &self.sent_m,
            mode: self.mode,
            from_outside: self.pace.is_some(),
            ground,
            step: self.step,
        };
        let mut commands_m = self.rig.commands(&self.design.command, &asked);
        if self.post.flags() & flag::ADJUSTED != 0 {
            for (j, command_m) in commands_m.iter_mut().enumerate() {
                *command_m *= self.post.axis(j).command_scale;
            }
        }
        commands_m
    }

    /// The ramp to a standstill begins at the last command, not at the target behind it; stop and go sends the target.
    /// Its speed is the target's, since differences of predicted commands contain the noise of the force.
    pub(super) fn stop_at_command(&mut self) {
        let ahead = self.design.predicts && self.pace != Some(Pace::StopAndGo);
        if ahead && self.mode.integrates() {
            self.signal.start_from(self.aimed_m);
            self.target_m = self.aimed_m;
        }
    }

    /// Actuator strokes with the structure at `at_m`; equal to `at_m` if the coordinates are the same.
    #[inline]
    pub(super) fn strokes_m<'a>(
        &self,
        at_m: &'a [f32; N],
        place: &'a mut [f32; N],
    ) -> &'a [f32; N] {
        if R::SAME_COORDINATES {
            return at_m;
        }
        *place = self.rig.strokes_m(at_m);
        place
    }

    /// The values that the actuator interlocks check before `next_m` is sent.
    #[inline]
    fn checked<'a>(
        &'a self,
        sample: &'a Sample<N>,
        displacement_m: &'a [f32; N],
        aimed_m: &'a [f32; N],
        next_m: &'a [f32; N],
        stale_steps: u16,
    ) -> Checked<'a, N> {
        Checked {
            next_m,
            sent_m: &self.sent_m,
            aimed_m,
            displacement_m: if R::SAME_COORDINATES {
                displacement_m
            } else {
                &sample.displacement_m
            },
            force_n: &sample.force_n,
            energy_ratio: self.monitor.ratio(),
            stale_steps,
            late_steps: self.signal.late_steps(),
            physical: self.design.physical,
        }
    }

    /// True if no interlock forbids sending `next_m`, which brings the structure to `aim_m`.
    #[inline]
    pub(super) fn may_send(
        &self,
        sample: &Sample<N>,
        displacement_m: &[f32; N],
        aim_m: &[f32; N],
        next_m: &[f32; N],
        stale_steps: u16,
    ) -> bool {
        if sample.fault.is_some() {
            return unlikely(false);
        }
        let mut place = [0.0; N];
        let aimed_m = self.strokes_m(&self.aimed_m, &mut place);
        let checked = self.checked(sample, displacement_m, aimed_m, next_m, stale_steps);
        // This check alone compiles to fewer instructions than one with an `and` that is always true.
        if R::SAME_COORDINATES {
            return within(&self.design.limits, &checked);
        }
        within(&self.design.limits, &checked) && self.rig.within(&self.aimed_m, aim_m)
    }

    /// Sends the command, unless it is not finite on an axis after the first `certain`.
    #[inline]
    pub(super) fn send(
        &mut self,
        certain: usize,
        target_m: [f32; N],
        aim_m: [f32; N],
        send_m: [f32; N],
    ) -> [f32; N] {
        // The interlocks have ensured finite actuator commands; only the numerical storeys remain to be checked.
        if (certain..N).all(|j| send_m[j].is_finite()) {
            self.target_m = target_m;
            self.aimed_m = aim_m;
            self.sent_m = send_m;
        }
        self.sent_m
    }

    /// An interlock forbids the command: latches the fault, or sends the command in a mode that cannot trip.
    #[cold]
    #[inline(never)]
    pub(super) fn trip_or_send(
        &mut self,
        sample: &Sample<N>,
        displacement_m: &[f32; N],
        stale_steps: u16,
        [target_m, aim_m, send_m]: [[f32; N]; 3],
    ) -> [f32; N] {
        let mut place = [0.0; N];
        let aimed_m = self.strokes_m(&self.aimed_m, &mut place);
        let checked = self.checked(sample, displacement_m, aimed_m, &send_m, stale_steps);
        let found = Finding::first(
            first_fault(&self.design.limits, &checked),
            self.rig.first_fault(&self.aimed_m, &aim_m),
        );
        // A fault reported by the board comes first, except over a NaN or, if no emergency itself, over an emergency.
        let finding = match sample.fault {
            None => found,
            Some(fault) => {
                let before = |f: &Finding| {
                    f.fault == Fault::NonFinite || f.fault.is_emergency() && !fault.is_emergency()
                };
                found.filter(before).or(Some(Finding::fact(fault)))
            }
        };
        if finding.is_some() {
            (self.obstacle, self.obstacle_tick) = (finding, self.tick);
        }
        let Some((found, after)) =
            finding.and_then(|f| Some((f, self.mode.after(Event::of(f.fault)).ok()?)))
        else {
            return self.send(0, target_m, aim_m, send_m);
        };
        // The first fault stays the recorded reason, even if others follow on the ramp.
        self.trip.get_or_insert(Trip {
            fault: found.fault,
            axis: found.axis,
            value: found.value,
            limit: found.limit,
            tick: self.tick,
        });
        if after == Mode::Stopping {
            // No limit forbids this command, and the ramp begins at it.
            self.send(0, target_m, aim_m, send_m);
        }
        self.mode = self.stopping(after);
        self.sent_m
    }

    /// The mode after a fault that asks for `after`: a ramp to a standstill begins at the last command; one that would
    /// take too long is not used.
    #[cold]
    #[inline(never)]
    pub(super) fn stopping(&mut self, after: Mode) -> Mode {
        if after == Mode::Stopping {
            self.stop_at_command();
            if !self.stops_soon() {
                return Mode::Tripped;
            }
        }
        after
    }
}
