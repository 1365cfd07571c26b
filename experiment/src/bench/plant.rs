//! The closed loop of core and the simulated rig, in this process.

use super::interface::{Bench, Ending, PreparedTest};
use crate::coupled::part::CoupledPart;
use crate::failure::Failure;
use crate::trace::{AnyRecord, TestObserver};
use ::plant::coupled::CoupledReading;
use ::plant::{Rig, RigSpec};
use outerloop_core::coupled::CoupledRig;
use outerloop_core::watch::Instructions;
use outerloop_core::{Event, Fault, InPlace, Mode, OuterLoop, Record, Rejected, Sample, flag};
use std::time::Instant;

/// Idle steps before arming: the loop averages the readings at rest.
pub const IDLE_STEPS: usize = 256;

/// Control steps for which the target must be constant after a ramp before the run ends.
pub const STANDS_STEPS: usize = 500;

/// Control steps over which a gain changes: hydraulics have no jumps.
pub const GAIN_STEPS: usize = 100;

/// A failure in a rig while a test runs.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Breakage {
    /// Displacement per command changes by this factor, over `GAIN_STEPS` control steps.
    ActuatorGain(f64),
    /// The force changes by this factor, as if the specimen were a different one.
    Stiffness(f64),
    /// The displacement keeps its last reading, plus its noise.
    DeadDisplacement,
    /// The force reads only its noise.
    DeadForce,
}

/// The loop's sample of a simulated rig: displacements, m, and forces, N, as delivered by its converters.
pub fn sample<const N: usize>(
    (displacement_m, force_n): (&[f64], &[f64]),
    at_rail: bool,
) -> Sample<N> {
    let mut sample = Sample::new([0.0; N], [0.0; N]);
    for j in 0..N.min(displacement_m.len()).min(force_n.len()) {
        sample.displacement_m[j] = displacement_m[j] as f32;
        sample.force_n[j] = force_n[j] as f32;
    }
    sample.fault = at_rail.then_some(Fault::AdcRail);
    sample
}

/// Arms a loop that has read its rig at rest, and starts it.
#[derive(Debug, Default)]
pub struct FromRest {
    idle_steps: usize,
}

impl FromRest {
    /// What a loop in this mode needs; false if it is on its way or further.
    ///
    /// # Errors
    /// A loop that refuses to be armed.
    pub fn care<const N: usize, R: outerloop_core::Rig<N>>(
        &mut self,
        outer: &mut OuterLoop<N, R>,
        mode: Mode,
    ) -> Result<bool, Failure> {
        match mode {
            Mode::Idle if self.idle_steps >= IDLE_STEPS => {
                let why = |refused: Rejected| {
                    format!(
                        "{refused}: accepted is a rig at rest within its limits, noise included"
                    )
                };
                let armed = outer.handle(Event::Arm);
                armed.map_err(|refused| Failure::test(why(refused)))?;
            }
            Mode::Idle => self.idle_steps += 1,
            Mode::Armed => drop(outer.handle(Event::Start)),
            Mode::Running
            | Mode::Resuming
            | Mode::Approaching
            | Mode::Returning
            | Mode::Commissioning
            | Mode::Holding
            | Mode::Finished
            | Mode::Stopping
            | Mode::Tripped => return Ok(false),
        }
        Ok(true)
    }
}

/// For how many steps a target has not moved.
#[derive(Debug)]
struct Standing<const N: usize> {
    target_m: [f32; N],
    steps: usize,
}

impl<const N: usize> Standing<N> {
    fn count(&mut self, target_m: [f32; N]) {
        let same = target_m == self.target_m;
        self.steps = if same { self.steps + 1 } else { 0 };
        self.target_m = target_m;
    }
}

/// A simulated rig.
#[derive(Clone, Copy, Debug)]
pub struct PlantBench<'a> {
    /// Its description.
    pub spec: &'a RigSpec,
    /// Seed of everything random in it.
    pub seed: u64,
    /// A test that computes a larger displacement is stopped, m: a real rig would have reached its limit.
    pub stop_beyond_m: f64,
    /// The failure, and the number of control steps of the running test after which it occurs.
    pub breaks: Option<(usize, Breakage)>,
}

impl Bench for PlantBench<'_> {
    fn run<const N: usize>(
        &self,
        test: &PreparedTest<'_, N>,
        observer: &mut dyn TestObserver,
    ) -> Result<Ending, Failure> {
        let config = test.config;
        let physical = config.physical_storeys().min(N);
        let storeys = &config.structure.stiffness_n_per_m[..physical];
        let mut rig = Rig::new(self.spec, storeys, config.timing.rate_hz, self.seed)
            .map_err(Failure::input)?;
        let mut last_m = [0.0; N];
        let (ending, _) = self.drive(test, observer, |command_m, done, mode| {
            let broken = self.breaks.filter(|(after, _)| done >= *after);
            let broken = broken.map(|(_, what)| what);
            if let Some(Breakage::ActuatorGain(gain)) = broken {
                let since = done - self.breaks.map_or(0, |(after, _)| after);
                let share = (since as f64 / GAIN_STEPS as f64).min(1.0);
                let gain = 1.0 + share * (gain - 1.0);
                command_m.iter_mut().for_each(|command| *command *= gain);
            }
            if mode == Mode::Running {
                rig.begin_test(config.timing.time_scale);
            }
            let reading = rig.step(&command_m[..physical]);
            let read = (&reading.displacement_m[..], &reading.force_n[..]);
            let mut sample = sample(read, reading.at_rail);
            for j in 0..physical {
                let noise_m = reading.displacement_m[j] - reading.true_displacement_m[j];
                let noise_n = reading.force_n[j] - reading.true_force_n[j];
                match broken {
                    Some(Breakage::Stiffness(times)) => {
                        sample.force_n[j] = (times * reading.true_force_n[j] + noise_n) as f32;
                    }
                    Some(Breakage::DeadDisplacement) => {
                        sample.displacement_m[j] = (last_m[j] + noise_m) as f32;
                    }
                    Some(Breakage::DeadForce) => sample.force_n[j] = noise_n as f32,
                    Some(Breakage::ActuatorGain(_)) | None => {
                        last_m[j] = reading.true_displacement_m[j];
                    }
                }
            }
            (sample, None)
        })?;
        Ok(ending)
    }

    fn run_coupled<const N: usize>(
        &self,
        part: &CoupledPart,
        test: &PreparedTest<'_, N, CoupledRig>,
        observer: &mut dyn TestObserver,
    ) -> Result<Ending, Failure> {
        let rate_hz = test.config.timing.rate_hz;
        let rig = part.simulated(&self.spec.sensors, rate_hz, self.seed);
        let mut rig = rig.map_err(Failure::input)?;
        let (ending, outer) = self.drive(test, observer, |command_m, _, _| {
            let reading = rig.step([0, 1].map(|i| command_m.get(i).copied().unwrap_or(0.0)));
            let read = (&reading.stroke_m[..], &reading.force_n[..]);
            (sample(read, reading.at_rail), Some(reading))
        })?;
        Ok(Ending {
            actuators: Some(*outer.rig().plant()),
            ..ending
        })
    }
}

impl PlantBench<'_> {
    /// True if the computed displacement has left the range of interest.
    fn is_beyond<const N: usize>(&self, record: &Record<N>) -> bool {
        let far = |u: &f32| f64::from(u.abs()) > self.stop_beyond_m;
        record.has(flag::SOLVED) && record.command_m.iter().any(far)
    }

    /// Arms, approaches and runs on a rig that returns a sample for the active commands, m, the number of control steps
    /// of the running test, and the mode.
    fn drive<const N: usize, R: outerloop_core::Rig<N>>(
        &self,
        test: &PreparedTest<'_, N, R>,
        observer: &mut dyn TestObserver,
        mut rig: impl FnMut(&mut [f64; N], usize, Mode) -> (Sample<N>, Option<CoupledReading>),
    ) -> Result<(Ending, OuterLoop<N, R>), Failure> {
        let began = Instant::now();
        let mut outer = OuterLoop::new(test.design.clone());
        if let Some(told) = observer.watches_the_loop() {
            outer.watch(told.iter().any(Instructions::corrects));
        }
        let mut in_place = InPlace::beside(&outer);
        let mut command_m = [0.0; N];
        let mut from_rest = FromRest::default();
        let mut standing = Standing {
            target_m: [0.0; N],
            steps: 0,
        };
        let mut done = 0;
        let by_hand = loop {
            if done >= test.steps {
                break false;
            }
            let (sample, reading) = rig(&mut command_m, done, outer.mode());
            let before = outer.mode();
            let step = outer.step(&sample, &test.ground);
            command_m = step.command_m.map(f64::from);
            let record = *step.record;
            standing.count(record.command_m);
            if before.integrates() {
                observer.on_step(&AnyRecord {
                    coupled: reading.as_ref(),
                    ..(&record).into()
                });
                done += 1;
                if self.is_beyond(&record) {
                    break false;
                }
            } else if !from_rest.care(&mut outer, before)? {
                observer.on_idle_step(&(&record).into());
            }
            // As on a board, after each step: a running test is watched, even if it has only just resumed.
            in_place.judge(&mut outer, |blocks, orders| observer.judge(blocks, orders));
            // An event that is invalid in this mode is refused without effect.
            if let Some(event) = observer.requested_event()
                && outer.handle(event).is_ok()
                && event == Event::Stop
            {
                break true;
            }
            // The ramp after the ground motion belongs to the test: interlocks act on it, too.
            let ended = outer.mode() == Mode::Finished && standing.steps >= STANDS_STEPS;
            if ended || outer.mode() == Mode::Tripped {
                break false;
            }
        };
        let ending = Ending {
            mode: outer.mode(),
            trip: outer.trip(),
            by_hand,
            wall_s: began.elapsed().as_secs_f64(),
            board: None,
            actuators: None,
        };
        Ok((ending, outer))
    }
}
