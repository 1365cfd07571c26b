//! Core and the simulated rig in this process.

use super::mover::{Mover, Stop, TargetMeasurement};
use super::served_rig::{ServedRig, ServedStep};
use super::travel::Travel;
use crate::scope::Scope;
use experiment::bench::{IDLE_STEPS, sample};
use experiment::coupled::settings;
use experiment::failure::Failure;
use experiment::files::test::TestFile;
use experiment::floors::with_floors;
use outerloop_core::{Design, Event, GroundMotion, Mode, OuterLoop, Pace, Rig, Sample};
use plant::coupled::CoupledReading;
use std::time::{Duration, Instant};

/// A longer gap means that this process did not run: this is not the model's fault, so the simulated clock does not make
/// up for it. Waiting for a socket may take 8 ms, however short a wait is requested.
const GAP_S: f64 = 0.05;

/// The simulated rig of a test file. `keep`: every step is kept.
///
/// # Errors
/// A parameter that is refused.
pub fn simulated(
    test: &TestFile,
    seed: u64,
    keep: bool,
    scope: Option<Scope>,
) -> Result<Box<dyn Mover>, Failure> {
    let config = &test.config;
    let rate_hz = config.timing.rate_hz;
    if let Some(part) = &test.coupled {
        let declared = &part.declared;
        let design = settings::design::<2>(declared, config, declared.compensation)?;
        let rig = part.simulated(&test.plant.sensors, rate_hz, seed);
        let rig = Simulated::new(design, rig.map_err(Failure::input)?, test);
        return Ok(Box::new(Travel::new(rig, test, keep, scope)));
    }
    with_floors!(config.degrees_of_freedom(), N => {
        let design = Design::<N>::new(config).map_err(Failure::input)?;
        let stiffness = &config.structure.stiffness_n_per_m;
        let rig = plant::Rig::new(&test.plant, stiffness, rate_hz, seed)
            .map_err(Failure::input)?;
        let simulated = Simulated::new(design, rig, test);
        Ok(Box::new(Travel::new(simulated, test, keep, scope)))
    })
}

/// A stand-in for the laboratory.
trait Laboratory<const N: usize> {
    /// One control period with these commands, m.
    fn period(&mut self, command_m: &[f64; N]) -> Sampled<N>;
}

/// What the loop samples, and what is behind it.
struct Sampled<const N: usize> {
    sample: Sample<N>,
    behind: Behind<N>,
}

/// What is behind a sample.
enum Behind<const N: usize> {
    /// Displacement, m, and force, N, of each storey, in more digits than a sample has.
    Storeys([[f64; N]; 2]),
    /// Two coupled actuators, whose readings are not x and rotation.
    Interface(CoupledReading),
}

impl<const N: usize> Laboratory<N> for plant::Rig {
    fn period(&mut self, command_m: &[f64; N]) -> Sampled<N> {
        let read = self.step(command_m);
        let channels = [&read.displacement_m, &read.force_n];
        Sampled {
            sample: sample((channels[0], channels[1]), read.at_rail),
            behind: Behind::Storeys(channels.map(|all| std::array::from_fn(|j| all[j]))),
        }
    }
}

impl Laboratory<2> for plant::coupled::CoupledRig {
    fn period(&mut self, command_m: &[f64; 2]) -> Sampled<2> {
        let read = self.step(*command_m);
        Sampled {
            sample: sample((&read.stroke_m, &read.force_n), read.at_rail),
            behind: Behind::Interface(read),
        }
    }
}

struct Simulated<const N: usize, R: Rig<N>, L> {
    outer: OuterLoop<N, R>,
    rig: L,
    command_m: [f64; N],
    pace: Pace,
    rate_hz: f64,
    steps: u64,
    /// If the rig keeps to the wall clock: an instant and the step that belongs to it.
    clock: Option<(Instant, u64)>,
}

impl<const N: usize, R: Rig<N>, L: Laboratory<N>> Simulated<N, R, L> {
    fn new(design: Design<N, R>, rig: L, test: &TestFile) -> Self {
        let mut outer = OuterLoop::new(design);
        outer.set_pace(Some(test.serve.pace));
        Self {
            outer,
            rig,
            command_m: [0.0; N],
            pace: test.serve.pace,
            rate_hz: test.config.timing.rate_hz,
            steps: 0,
            clock: None,
        }
    }

    /// One control period, regardless of the clock.
    fn period(&mut self) -> ServedStep<N> {
        let Sampled { sample, behind } = self.rig.period(&self.command_m);
        let step = self.outer.step(&sample, &GroundMotion::none());
        self.command_m = step.command_m.map(f64::from);
        let record = *step.record;
        self.steps += 1;
        let mut reached = TargetMeasurement::estimated(&record);
        let coupled = match behind {
            Behind::Interface(read) => Some(read),
            // The correction that core applied to the sample is applied to the reading, which has more digits.
            Behind::Storeys([displacement_m, force_n]) => {
                for j in 0..N {
                    reached.displacement_m[j] +=
                        displacement_m[j] - f64::from(sample.displacement_m[j]);
                    reached.force_n[j] += force_n[j] - f64::from(sample.force_n[j]);
                }
                None
            }
        };
        ServedStep {
            record,
            reached,
            coupled,
            ended: self.outer.trip().map(Stop::Tripped),
        }
    }

    fn event(&mut self, event: Event) -> Result<(), Failure> {
        let refused = |e: outerloop_core::Rejected| Failure::test(e.to_string());
        self.outer.handle(event).map(drop).map_err(refused)
    }

    /// One control period during the approach to the start.
    fn approach(&mut self) -> Result<(), Failure> {
        match self.period().ended {
            Some(stop) => Err(Failure::test(stop.to_string())),
            None => Ok(()),
        }
    }

    /// By how many steps the wall clock is ahead.
    fn due(&mut self) -> f64 {
        let Some((began, first)) = &mut self.clock else {
            return 1.0;
        };
        let due = began.elapsed().as_secs_f64() * self.rate_hz - (self.steps - *first) as f64;
        if due > GAP_S * self.rate_hz {
            *began += Duration::from_secs_f64((due - 1.0) / self.rate_hz);
            return 1.0;
        }
        due
    }

    fn wait_for_the_clock(&mut self) {
        loop {
            let due = self.due();
            if due >= 1.0 {
                return;
            }
            std::thread::sleep(Duration::from_secs_f64((1.0 - due) / self.rate_hz));
        }
    }
}

impl<const N: usize, R: Rig<N>, L: Laboratory<N>> ServedRig<N> for Simulated<N, R, L> {
    fn begin(&mut self) -> Result<(), Failure> {
        for _ in 0..IDLE_STEPS {
            self.approach()?;
        }
        self.event(Event::Arm)?;
        while self.outer.mode() != Mode::Armed {
            self.approach()?;
        }
        Ok(())
    }

    fn aim(&mut self, target_m: [f32; N]) -> Result<(), Stop> {
        self.outer.set_next_target(target_m);
        // The test begins with its first target, so nothing can be late before.
        if self.outer.mode() == Mode::Armed {
            let lost = |e: Failure| Stop::Lost(e.to_string());
            self.event(Event::Start).map_err(lost)?;
            let paced = self.pace == Pace::Continuous;
            self.clock = paced.then(|| (Instant::now(), self.steps));
        }
        Ok(())
    }

    fn step(&mut self) -> Result<ServedStep<N>, Stop> {
        self.wait_for_the_clock();
        if self.outer.mode() == Mode::Holding && self.clock.is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        Ok(self.period())
    }

    fn meanwhile(&mut self) -> Result<Vec<ServedStep<N>>, Stop> {
        let mut seen = Vec::new();
        while self.clock.is_some() && self.due() >= 1.0 {
            seen.push(self.period());
        }
        Ok(seen)
    }

    fn has_own_time(&self) -> bool {
        self.pace == Pace::Continuous
    }

    fn request(&mut self, event: Event) -> Result<(), Stop> {
        // An event that does not apply in this mode is refused, without effect.
        let _ = self.outer.handle(event);
        Ok(())
    }

    fn answer_n(&self) -> Result<[f32; N], Stop> {
        Ok(*self.outer.answer_n())
    }

    fn end(&mut self) -> Result<(), Failure> {
        self.clock = None;
        while self.outer.mode() == Mode::Stopping {
            let _ = self.period();
        }
        if !matches!(
            self.outer.mode(),
            Mode::Idle | Mode::Armed | Mode::Approaching | Mode::Finished | Mode::Tripped
        ) {
            self.event(Event::Stop)?;
        }
        if self.outer.mode() == Mode::Finished {
            let mut before = [f64::NAN; N];
            while self.command_m != before && self.outer.mode() == Mode::Finished {
                before = self.command_m;
                let _ = self.period();
            }
        }
        match self.outer.mode() {
            Mode::Armed | Mode::Approaching => self.event(Event::Stop),
            Mode::Finished | Mode::Tripped => self.event(Event::Clear),
            _ => Ok(()),
        }
    }

    fn permit(&self) -> bool {
        self.outer.mode().permits_motion()
    }
}
