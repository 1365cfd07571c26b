//! One step of the outer loop. This file is the map of the crate.
//!
//! ```text
//!  sample ─► estimate ─► energy ─► compensate ─► integrate ─► generate ─► predict ─► interlock ─► command, record
//! ```
//!
//! The target `u_c` of the integration and the command that is sent for it are two things: a predictor sends the
//! actuator ahead of the target. Energies and errors are measured on the target; interlocks, the estimator's known input
//! and every standstill are about what is sent.
//!
//! # Timing
//! [`OuterLoop::step`] is called once a control period with what was sampled while the last command was in force, and
//! gives the command for the next. It does no input or output, never waits, and takes the same path in every call of
//! a kind; the caller measures it against its period and reports a miss as [`Fault::DeadlineMissed`].

mod operate;
mod outside;

pub use outside::Pace;

use crate::config::{Design, StepConstants};
use crate::energy::{EnergyErrors, Monitor, Observation};
use crate::estimate::{Estimate, Estimator};
use crate::float::larger;
use crate::force::{Acting, Correction, Law, Reached};
use crate::ground_motion::GroundMotion;
use crate::newmark::Newmark;
use crate::predict::{Ahead, Followed, Predictor};
use crate::record::{Record, flag};
use crate::rig::Rig;
use crate::signal::{SignalGenerator, Target};
use crate::supervise::{
    Checked, Event, Fault, Finding, History, LockWatch, Mode, Rejected, StaleWatch, Trip,
    first_fault, within,
};

/// What was measured in a control step, and what the board knows about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample<const N: usize> {
    /// Measured displacement of each axis, m. Axes without an actuator are not looked at.
    pub displacement_m: [f32; N],
    /// Measured force of each axis, N, positive where it resists positive displacement.
    pub force_n: [f32; N],
    /// Taken in this control period; a sample that is not is not integrated with.
    pub fresh: bool,
    /// What the board has to report: a rail, a missed deadline, a lost link, the emergency stop.
    pub fault: Option<Fault>,
}

impl<const N: usize> Sample<N> {
    /// A good sample.
    pub const fn new(displacement_m: [f32; N], force_n: [f32; N]) -> Self {
        Self {
            displacement_m,
            force_n,
            fresh: true,
            fault: None,
        }
    }
}

/// What a control step gives.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a, const N: usize> {
    /// Command for the next control period, m; always finite.
    pub command_m: [f32; N],
    /// Whether the actuator may move on it.
    pub permit: bool,
    /// The record of this step.
    pub record: &'a Record<N>,
}

/// The outer loop of a test with `N` degrees of freedom.
///
/// In this order: what every step touches lies in front of the long arrays, within the reach of one instruction, and
/// what only some compensations use behind them.
#[derive(Clone, Debug)]
#[repr(C)]
pub struct OuterLoop<const N: usize> {
    design: StepConstants<N>,
    mode: Mode,
    tick: u32,
    step: u32,
    flags: u32,
    ground_m_per_s2: f32,
    /// Command in force, m.
    sent_m: [f32; N],
    /// True displacement that this command is for, m: the target, or ahead of it.
    aimed_m: [f32; N],
    target_m: [f32; N],
    monitor: Monitor<N>,
    law: Law<N>,
    correction: Correction<N>,
    newmark: Newmark<N>,
    signal: SignalGenerator<N>,
    stale: StaleWatch<N>,
    lock: LockWatch,
    trip: Option<Trip>,
    obstacle: Option<Finding>,
    standing_m: Option<[f32; N]>,
    /// While commissioning: the command of the next step, m.
    goal_m: [f32; N],
    energy: EnergyErrors<N>,
    estimator: Estimator<N>,
    history: History<N>,
    predictor: Predictor<N>,
    rig: Rig<N>,
    /// Last change of where the actuator was sent, m per control step, where there is a predictor.
    aimed_step_m: [f32; N],
    /// By how much the last target was led, m.
    led_by_m: [f32; N],
    /// While resuming: the share of the prediction that is sent.
    share: f32,
    /// Where the targets come from outside: how they are gone to, the next of them, and the force that the last was
    /// answered with.
    pace: Option<Pace>,
    next_target_m: Option<[f32; N]>,
    answer_n: [f32; N],
}

impl<const N: usize> OuterLoop<N> {
    /// An idle loop.
    pub fn new(design: Design<N>) -> Self {
        let Design {
            step: design,
            law,
            predictor,
            estimation,
            rig,
        } = design;
        let diagonal = core::array::from_fn(|j| design.specimen_stiffness[j][j]);
        Self {
            mode: Mode::Idle,
            trip: None,
            obstacle: None,
            history: History::new(),
            tick: 0,
            step: 0,
            sent_m: [0.0; N],
            aimed_m: [0.0; N],
            target_m: [0.0; N],
            aimed_step_m: [0.0; N],
            led_by_m: [0.0; N],
            share: 0.0,
            standing_m: None,
            goal_m: [0.0; N],
            estimator: Estimator::at_rest(&estimation, [0.0; N]),
            energy: EnergyErrors::new(design.specimen_stiffness, usize::from(design.window_steps)),
            monitor: Monitor::new(diagonal, design.energy_floor_j),
            law,
            predictor,
            rig: Rig::new(rig),
            correction: Correction::NONE,
            newmark: Newmark::at_rest(),
            signal: SignalGenerator::standing_at([0.0; N]),
            stale: StaleWatch::new(design.frozen_m),
            lock: LockWatch::default(),
            flags: 0,
            ground_m_per_s2: 0.0,
            pace: None,
            next_target_m: None,
            answer_n: [0.0; N],
            design,
        }
    }

    /// One control step: sample in, command and record out.
    ///
    /// A function of its own: inlined into a main loop it would share that loop's registers, which costs more than the
    /// call.
    #[inline(never)]
    pub fn step(&mut self, sample: &Sample<N>, ground: &GroundMotion<'_>) -> Step<'_, N> {
        self.flags = 0;
        let stale_steps = self.watch(sample);
        // From here on the displacement is the true one, as far as it is known; interlocks on the force and the record
        // keep what was read.
        let (mut displacement_m, mut force_n) = (sample.displacement_m, sample.force_n);
        if self.design.corrects {
            self.rig.correct(&mut displacement_m, &mut force_n);
        }
        let estimate = self.estimate(displacement_m, force_n);
        let fit = stale_steps == 0;
        let next_m = match self.mode {
            Mode::Idle => self.follow(&displacement_m),
            Mode::Approaching => self.approach_start(),
            Mode::Armed => [0.0; N],
            Mode::Running | Mode::Resuming => match self.pace {
                None => self.run(&estimate, ground, fit),
                Some(pace) => self.run_outside(pace, &estimate, fit),
            },
            Mode::Returning => self.return_to_target(),
            Mode::Commissioning => self.pursue(),
            Mode::Holding | Mode::Finished => self.slow_down(),
            Mode::Tripped => self.aimed_m,
        };
        let (mut aim_m, mut send_m) = (next_m, next_m);
        if self.design.predicts {
            aim_m = self.predict(estimate.displacement_m, next_m, fit);
            send_m = self.commands(&aim_m);
        }
        let finding = self.interlock(sample, &displacement_m, &send_m, stale_steps);
        self.record(sample, &estimate);
        let command_m = self.supervise(finding, next_m, aim_m, send_m);
        if self.mode.integrates() && self.pace.is_none() && self.step > ground.steps() {
            self.stop_where_it_is();
            self.mode = Mode::Finished;
        }
        self.tick = self.tick.wrapping_add(1);
        Step {
            command_m,
            permit: self.mode.permits_motion(),
            record: self.history.latest(),
        }
    }

    /// A commissioning signal in place of the test: the command goes where it is told.
    fn pursue(&mut self) -> [f32; N] {
        self.signal.follow(self.goal_m);
        self.goal_m
    }

    /// The running test: solve when the target has been reached, then go on towards the next.
    #[inline]
    fn run(&mut self, estimate: &Estimate<N>, ground: &GroundMotion<'_>, fit: bool) -> [f32; N] {
        if self.signal.at_target() && fit {
            self.solve(estimate, ground.at(self.step));
        }
        self.signal.advance(&self.design.signal);
        if self.signal.late_steps() > 0 {
            self.flags |= flag::LATE;
        }
        *self.signal.command_m()
    }

    /// A step of the slow way to the start position.
    fn approach_start(&mut self) -> [f32; N] {
        let next_m = self.approach([0.0; N]);
        if next_m == [0.0; N] {
            self.mode = Mode::Armed;
        }
        next_m
    }

    /// After a hold: a step of the slow way back to the target at which the test stands.
    fn return_to_target(&mut self) -> [f32; N] {
        let target_m = self.newmark.displacement_m();
        let next_m = self.approach(target_m);
        // A hold on the way begins where the command is.
        self.signal.follow(next_m);
        if self.target_m == target_m {
            self.signal = SignalGenerator::standing_at(target_m);
            self.share = 0.0;
            self.mode = if self.design.predicts {
                Mode::Resuming
            } else {
                Mode::Running
            };
        }
        next_m
    }

    /// Energy errors and compensation at a target that has been reached: what was observed, the force that the equation
    /// of motion takes, and the damping that acts in it.
    #[inline]
    fn compensate(&mut self, estimate: &Estimate<N>) -> (Observation<N>, [f32; N], [f32; N]) {
        let now = Observation {
            command_m: self.newmark.displacement_m(),
            increment_m: *self.newmark.increment_m(),
            displacement_m: estimate.displacement_m,
            force_n: estimate.force_n,
        };
        let energy = self.energy.update(&now, self.design.physical);

        let Acting {
            force_n,
            damping,
            correction,
        } = self.law.act(&Reached {
            now: &now,
            energy: &energy,
            velocity_dt_m: self.newmark.velocity_dt_m(),
            predictor_velocity_dt_m: self.newmark.predictor_velocity_dt_m(),
        });
        self.correction = correction;
        (now, force_n, damping)
    }

    /// One integration step: energy, compensation, equation of motion, next target.
    #[inline]
    fn solve(&mut self, estimate: &Estimate<N>, ground_m_per_s2: f32) {
        let (now, force_n, damping) = self.compensate(estimate);
        let k = &self.design;
        let load_n = k.newmark.load_n(ground_m_per_s2);
        let mut correction_n = self
            .newmark
            .advance(&k.newmark, &load_n, &force_n, &damping);
        for j in 0..N.min(k.physical) {
            correction_n[j] += force_n[j] - now.force_n[j];
        }
        let hsem_j = self.energy.cumulative().hsem_j;
        self.monitor
            .update(&now, k.physical, load_n, correction_n, hsem_j);

        self.signal.aim(&k.signal, self.target());
        self.close_step(ground_m_per_s2);
    }

    /// The target that the integration has come to.
    #[inline]
    fn target(&self) -> Target<N> {
        Target {
            displacement_m: self.newmark.displacement_m(),
            velocity_dt_m: self.newmark.predictor_velocity_dt_m(),
            acceleration_dt2_m: *self.newmark.acceleration_dt2_m(),
        }
    }

    /// Counts the integration step and looks for a structure that its own damping locks.
    #[inline]
    fn close_step(&mut self, ground_m_per_s2: f32) {
        let k = &self.design;
        let mut added_ratio = 0.0_f32;
        for j in 0..N.min(k.physical) {
            let ratio = self.correction.damping[j] * k.per_critical[j];
            added_ratio = larger(added_ratio, ratio.abs());
        }
        if self.lock.update(added_ratio, k.per_period) > k.limits.locked_damping_ratio {
            self.flags |= flag::LOCKED;
        }
        self.ground_m_per_s2 = ground_m_per_s2;
        self.step = self.step.wrapping_add(1);
        self.flags |= flag::SOLVED;
    }

    /// For how long samples have been stale.
    #[inline]
    fn watch(&mut self, sample: &Sample<N>) -> u16 {
        // Idle, the command follows the sensor: a command that moves and a sensor that stands are then no contradiction.
        let watched = if self.mode == Mode::Idle {
            0
        } else {
            self.design.physical
        };
        // The target's motion counts: a predictor's command jumps with the noise, and two equal words are a chance then.
        let steps = self.stale.update(
            sample.fresh,
            &sample.displacement_m,
            &self.target_m,
            watched,
        );
        if steps > 0 {
            self.flags |= flag::STALE;
        }
        steps
    }

    /// What the loop believes of the specimen; numerical degrees of freedom are where they were sent.
    #[inline]
    fn estimate(&mut self, mut displacement_m: [f32; N], mut force_n: [f32; N]) -> Estimate<N> {
        let k = &self.design;
        for j in k.physical..N {
            displacement_m[j] = self.target_m[j];
            force_n[j] = 0.0;
        }
        let estimate = self
            .estimator
            .update(&self.aimed_m, &displacement_m, &force_n, k.physical);
        // A model that fits has 1; twice that over a second of samples is no chance.
        if estimate.innovation.iter().any(|&i| !(i <= 2.0)) {
            self.flags |= flag::MODEL_DOUBT;
        }
        estimate
    }

    /// Idle: the target follows the true position, and the command is what holds the actuator there, so that arming
    /// moves nothing whatever is known of offsets and gains.
    fn follow(&mut self, displacement_m: &[f32; N]) -> [f32; N] {
        let mut standing_m = self.standing_m.unwrap_or(*displacement_m);
        for (mean, &new) in standing_m.iter_mut().zip(displacement_m) {
            // A mean over some 64 samples, so that noise is not a bump.
            let moved = *mean + (new - *mean) * (1.0 / 64.0);
            *mean = if moved.is_finite() { moved } else { 0.0 };
        }
        self.standing_m = Some(standing_m);
        standing_m
    }

    /// A step of the slow approach to `goal_m`.
    fn approach(&self, goal_m: [f32; N]) -> [f32; N] {
        let step = self.design.approach_step_m;
        core::array::from_fn(|j| {
            let rest = goal_m[j] - self.target_m[j];
            if rest.abs() <= step {
                goal_m[j]
            } else {
                self.target_m[j] + step.copysign(rest)
            }
        })
    }

    /// A step of the ramp to hold: the velocity of the command goes to zero at the set deceleration.
    fn slow_down(&mut self) -> [f32; N] {
        self.signal.decelerate(self.design.deceleration_step_m);
        *self.signal.command_m()
    }

    /// What is sent for the target `next_m`: the predictor's answer while the test runs, else the target itself. The
    /// predictor sees every step, so that its memory is of what really happened.
    #[inline(never)]
    fn predict(&mut self, measured_m: [f32; N], next_m: [f32; N], fit: bool) -> [f32; N] {
        let k = &self.design;
        let live = self.mode.integrates() && self.pace != Some(Pace::StopAndGo);
        let (mut velocity_m, mut acceleration_m) = ([0.0; N], [0.0; N]);
        if live {
            velocity_m = *self.signal.velocity_m();
            acceleration_m = self.signal.acceleration_m(&k.signal);
        }
        let followed = core::array::from_fn(|j| Followed {
            target_m: self.target_m[j] + self.led_by_m[j],
            sent_m: self.aimed_m[j],
            measured_m: measured_m[j],
            learn: live && fit,
        });
        let mut ahead: [Ahead; N] = core::array::from_fn(|j| Ahead {
            displacement_m: next_m[j],
            velocity_m: velocity_m[j],
            acceleration_m: acceleration_m[j],
        });
        let mut send_m = next_m;
        if k.lead_steps != 0.0 {
            // Numerical degrees of freedom are sent where they are wanted.
            for j in 0..N {
                ahead[j] = ahead[j].led_by(k.lead_steps);
                self.led_by_m[j] = ahead[j].displacement_m - next_m[j];
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
                send_m[j] = next_m[j] + self.share * (send_m[j] - next_m[j]);
            }
            self.share += k.resume_step;
            if self.share >= 1.0 {
                self.mode = Mode::Running;
            }
        }
        for j in 0..N {
            self.aimed_step_m[j] = send_m[j] - self.aimed_m[j];
        }
        send_m
    }

    /// What is sent so that the actuator goes to `aim_m`.
    #[inline]
    fn commands(&self, aim_m: &[f32; N]) -> [f32; N] {
        core::array::from_fn(|j| self.design.command[j].towards(aim_m[j]))
    }

    /// The ramp to a standstill begins at what was sent and not at the target behind it.
    fn stop_where_it_is(&mut self) {
        if self.design.predicts && self.mode.integrates() {
            self.signal.go_on_from(self.aimed_m, self.aimed_step_m);
            self.target_m = self.aimed_m;
        }
    }

    /// What stands against sending `next_m`.
    #[inline]
    fn interlock(
        &self,
        sample: &Sample<N>,
        displacement_m: &[f32; N],
        next_m: &[f32; N],
        stale_steps: u16,
    ) -> Option<Finding> {
        let checked = Checked {
            next_m,
            sent_m: &self.sent_m,
            aimed_m: &self.aimed_m,
            displacement_m,
            force_n: &sample.force_n,
            energy_ratio: self.monitor.ratio(),
            stale_steps,
            late_steps: self.signal.late_steps(),
            physical: self.design.physical,
        };
        if sample.fault.is_none() && within(&self.design.limits, &checked) {
            return None;
        }
        let found = first_fault(&self.design.limits, &checked);
        // What the board reports comes first, but for a number that is none.
        match sample.fault {
            None => found,
            Some(fault) => {
                let not_finite = found.filter(|f| f.fault == Fault::NonFinite);
                not_finite.or(Some(Finding::fact(fault)))
            }
        }
    }

    /// Sends the command or latches the fault.
    #[inline]
    fn supervise(
        &mut self,
        finding: Option<Finding>,
        target_m: [f32; N],
        aim_m: [f32; N],
        send_m: [f32; N],
    ) -> [f32; N] {
        self.obstacle = finding;
        if let (Some(f), Ok(tripped)) = (finding, self.mode.after(Event::Fault)) {
            self.mode = tripped;
            self.trip = Some(Trip {
                fault: f.fault,
                axis: f.axis,
                value: f.value,
                limit: f.limit,
                tick: self.tick,
            });
            return self.sent_m;
        }
        if send_m.iter().all(|x| x.is_finite()) {
            self.target_m = target_m;
            self.aimed_m = aim_m;
            self.sent_m = send_m;
        }
        self.sent_m
    }

    /// Writes the record of this step; the history ends with the step that tripped.
    #[inline]
    fn record(&mut self, sample: &Sample<N>, estimate: &Estimate<N>) {
        let k = &self.design;
        if self.monitor.ratio() > k.limits.energy_warning {
            self.flags |= flag::ENERGY_WARNING;
        }
        if self.correction.held {
            self.flags |= flag::HELD;
        }
        if self.correction.clamped {
            self.flags |= flag::CLAMPED;
        }
        let fault = self.trip.map_or(0, |t| u32::from(t.fault.code()));
        *self.history.place(self.mode != Mode::Tripped) = Record {
            tick: self.tick,
            step: self.step,
            flags: self.mode as u32 | fault << 8 | self.flags,
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
    }
}
