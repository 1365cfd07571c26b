//! One control step, in the order in which it happens.
//!
//! ```text
//!  sample ─► correct ─► estimate ─► energy ─► force law ─► integrate ─► generate ─► predict ─► interlock ─► record, command
//! ```
//!
//! Two choices here serve the processor: code that a test integrated here does not need is behind a call, and its
//! arguments are copies, so that the originals can stay in registers.

use super::{OuterLoop, Sample, Step};
use crate::energy::Observation;
use crate::estimate::Estimate;
use crate::float::larger;
use crate::force::{LawInput, LawOutput};
use crate::ground_motion::GroundMotion;
use crate::record::{Record, flag};
use crate::rig::Rig;
use crate::signal::Target;
use crate::structure::actuated;
use crate::supervise::{Mode, Staleness};

impl<const N: usize, R: Rig<N>> OuterLoop<N, R> {
    /// One control step: sample in, command and record out.
    ///
    /// Not inlined: in a main loop it would share that loop's registers, which costs more than the call.
    #[inline(never)]
    pub fn step(&mut self, sample: &Sample<N>, ground: &GroundMotion<'_>) -> Step<'_, N> {
        self.flags = self.post.flags();
        let Staleness {
            usable,
            steps: stale_steps,
        } = self.watch_samples(sample);
        let (displacement_m, force_n) = self.correct(sample);
        let estimate = self.estimate(displacement_m, force_n);
        // A test runs whose targets are not external.
        let integrates_here = self.mode.integrates() && self.pace.is_none();
        if self.target_reached(integrates_here, usable) {
            self.solve(integrates_here, &estimate, ground);
        }
        let next_m = if integrates_here {
            self.advance_command()
        } else {
            let copy_m = displacement_m;
            self.command_without_integration(&copy_m, sample.chain_open)
        };
        let (mut aim_m, mut send_m) = (next_m, next_m);
        if self.design.predicts {
            aim_m = self.predict(estimate.displacement_m, next_m, usable);
            send_m = self.commands(&aim_m, ground);
        }
        let may_send = self.may_send(sample, &displacement_m, &aim_m, &send_m, stale_steps);
        let place = self.record(sample, &estimate);
        let command_m = if may_send {
            self.send(actuated::<N>(self.design.physical), next_m, aim_m, send_m)
        } else {
            let copy_m = displacement_m;
            self.trip_or_send(sample, &copy_m, stale_steps, [next_m, aim_m, send_m])
        };
        if integrates_here && self.step > ground.steps() && self.mode.integrates() {
            self.finish();
        }
        self.tick = self.tick.wrapping_add(1);
        Step {
            command_m,
            permit: self.mode.permits_motion(),
            record: self.history.at(place),
        }
    }

    /// True if the target of an integration step has been reached, with a sample that may be integrated with.
    #[inline]
    fn target_reached(&self, integrates_here: bool, usable: bool) -> bool {
        if integrates_here {
            usable && self.signal.at_target()
        } else {
            self.outside_target_reached(usable)
        }
    }

    /// One integration step: energy, compensation, equation of motion, next target.
    #[inline]
    fn solve(&mut self, integrates_here: bool, estimate: &Estimate<N>, ground: &GroundMotion<'_>) {
        let now = Observation {
            command_m: self.newmark.displacement_m(),
            increment_m: *self.newmark.increment_m(),
            displacement_m: estimate.displacement_m,
            force_n: estimate.force_n,
        };
        let LawOutput { force_n, damping } = self.compensate(&now);
        let physical = self.design.physical;
        let (mut ground_m_per_s2, mut load_n) = (0.0, [0.0; N]);
        let mut correction_n;
        if integrates_here {
            let k = &self.design.newmark;
            ground_m_per_s2 = ground.at(self.step);
            load_n = k.load_n(ground_m_per_s2);
            correction_n = self.newmark.advance(k, &load_n, &force_n, &damping);
        } else {
            // The external load is unknown here: the monitor's scale is the strain energy alone.
            let (now, force_n, damping) = (now, force_n, damping);
            correction_n = self.answer(&now, &force_n, &damping);
        }
        for j in 0..actuated::<N>(physical) {
            correction_n[j] += force_n[j] - now.force_n[j];
        }
        let hsem_j = self.energy.cumulative().hsem_j;
        self.monitor
            .update(&now, physical, load_n, correction_n, hsem_j);
        if integrates_here {
            self.signal.aim(&self.design.signal, self.target());
        }
        self.close_step(ground_m_per_s2);
    }

    /// One step towards the target of the running test.
    #[inline]
    fn advance_command(&mut self) -> [f32; N] {
        if self.signal.advance(&self.design.signal) {
            self.flags |= flag::LATE;
        }
        *self.signal.command_m()
    }

    /// Energy errors and compensation at a reached target: gives force and damping for the equation of motion.
    #[inline]
    fn compensate(&mut self, now: &Observation<N>) -> LawOutput<N> {
        let energy = self.energy.update(now, self.design.physical);
        let reached = LawInput {
            now,
            energy: &energy,
            velocity_dt_m: self.newmark.velocity_dt_m(),
            predictor_velocity_dt_m: self.newmark.predictor_velocity_dt_m(),
        };
        self.law.act(&reached, &mut self.correction)
    }

    /// The target that the integration has reached.
    #[inline]
    pub(super) fn target(&self) -> Target<N> {
        Target {
            displacement_m: self.newmark.displacement_m(),
            velocity_dt_m: self.newmark.predictor_velocity_dt_m(),
            acceleration_dt2_m: *self.newmark.acceleration_dt2_m(),
        }
    }

    /// Counts the integration step and checks for a structure locked by its own damping.
    #[inline]
    fn close_step(&mut self, ground_m_per_s2: f32) {
        let k = &self.design;
        let mut added_ratio = 0.0_f32;
        for j in 0..actuated::<N>(k.physical) {
            let ratio = (self.correction.damping[j] * k.per_critical[j]).abs();
            added_ratio = if j == 0 {
                ratio
            } else {
                larger(added_ratio, ratio)
            };
        }
        if self.lock.update(added_ratio, k.per_period) > k.limits.locked_damping_ratio {
            self.flags |= flag::LOCKED;
        }
        self.ground_m_per_s2 = ground_m_per_s2;
        self.step = self.step.wrapping_add(1);
        self.flags |= flag::SOLVED;
    }

    /// Whether the sample may be integrated with, and for how many control steps samples have been stale.
    #[inline]
    fn watch_samples(&mut self, sample: &Sample<N>) -> Staleness {
        // While idle the command follows the sensor: a moving command with a constant reading is then no contradiction.
        let watched = if self.mode == Mode::Idle {
            0
        } else {
            self.design.physical
        };
        // Use the target's motion: a predictor's command jumps with noise, and two equal readings may then be chance.
        let mut place = [0.0; N];
        let target_m = self.strokes_m(&self.target_m, &mut place);
        let seen = self
            .stale
            .update(sample.fresh, &sample.displacement_m, target_m, watched);
        if !seen.usable {
            let missed = if sample.fresh { 0 } else { flag::MISSED };
            self.flags |= flag::STALE | missed;
        }
        seen
    }

    /// The best known true displacement and force in the structure's coordinates; force interlocks and the record keep
    /// the raw readings.
    #[inline]
    fn correct(&mut self, sample: &Sample<N>) -> ([f32; N], [f32; N]) {
        if !self.design.corrects {
            return (sample.displacement_m, sample.force_n);
        }
        let (mut displacement_m, mut force_n) = (sample.displacement_m, sample.force_n);
        let runs = self.mode.integrates();
        // On a rig at rest an offset looks like a gain, more so with each sample.
        let moves = runs && self.signal.velocity_m().iter().any(|v| *v != 0.0);
        self.rig
            .correct(&self.sent_m, moves, &mut displacement_m, &mut force_n);
        if self.post.flags() & flag::ADJUSTED != 0 && runs {
            let velocity_m = self.signal.velocity_m();
            for j in 0..N {
                displacement_m[j] += self.post.axis(j).reading_late_steps * velocity_m[j];
            }
        }
        (displacement_m, force_n)
    }

    /// The loop's estimate of the specimen; numerical degrees of freedom are where they were sent.
    #[inline]
    fn estimate(&mut self, mut displacement_m: [f32; N], mut force_n: [f32; N]) -> Estimate<N> {
        let k = &self.design;
        for j in 0..N {
            if j >= actuated::<N>(k.physical) {
                displacement_m[j] = self.target_m[j];
                force_n[j] = 0.0;
            }
        }
        let estimate = self
            .estimator
            .update(&self.aimed_m, &displacement_m, &force_n, k.physical);
        if estimate.doubt {
            self.flags |= flag::MODEL_DOUBT;
        }
        estimate
    }

    /// Writes the record of this step, and says where; the history ends with the step that tripped.
    #[inline(always)] // A call would hand the estimate through memory.
    fn record(&mut self, sample: &Sample<N>, estimate: &Estimate<N>) -> usize {
        let k = &self.design;
        let mut flags = self.flags;
        if self.monitor.ratio() > k.limits.energy_warning {
            flags |= flag::ENERGY_WARNING;
        }
        if self.correction.held {
            flags |= flag::HELD;
        }
        if self.correction.clamped {
            flags |= flag::CLAMPED;
        }
        let fault = self.trip.map_or(0, |t| u32::from(t.fault.code()));
        let place = self.history.advance(!self.mode.is_faulted());
        *self.history.at_mut(place) = Record {
            tick: self.tick,
            step: self.step,
            flags: self.mode as u32 | fault << 8 | flags,
            ground_m_per_s2: self.ground_m_per_s2,
            command_m: self.target_m,
            sent_m: self.sent_m,
            displacement_m: sample.displacement_m,
            force_n: sample.force_n,
            estimated_displacement_m: estimate.displacement_m,
            estimated_force_n: estimate.force_n,
            velocity_m_per_s: self.newmark.velocity_dt_m().map(|q| q * k.newmark.rate_hz),
            acceleration_m_per_s2: self
                .newmark
                .acceleration_dt2_m()
                .map(|s| s * k.newmark.rate_squared),
            added_damping_n_s_per_m: self.correction.damping,
            gain: self.correction.gain,
            energy_step: self.energy.step().into(),
            energy_sum: self.energy.cumulative().into(),
            energy_input_j: self.monitor.input_j(),
            energy_ratio: self.monitor.ratio(),
            innovation: estimate.innovation,
        };
        place
    }
}
