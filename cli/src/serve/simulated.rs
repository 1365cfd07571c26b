//! Core and the simulated rig in this process.

use super::ledger::Ledger;
use super::mover::{Mover, Reached, Stop};
use super::settings::Settings;
use crate::bench::with_floors;
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::scope::Scope;
use crate::trace::{Trace, Witness};
use outerloop_core::outer_loop::Pace;
use outerloop_core::record::flag;
use outerloop_core::{Design, Event, Fault, GroundMotion, Mode, OuterLoop, Record, Sample};
use plant::Rig;
use std::time::{Duration, Instant};

/// Idle steps before arming: the loop averages where the specimen stands.
const IDLE_STEPS: usize = 256;
/// A gap in which this process did not run is this machine's and not the model's: the simulated clock does not make up
/// for it. Waiting for a socket may take 8 ms, however short it is asked to be.
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
    with_floors!(config.degrees_of_freedom(), N => {
        let refused = |e: outerloop_core::Refusal| Failure::input(e.to_string());
        let design = Design::<N>::new(config).map_err(refused)?;
        let rate_hz = config.timing.rate_hz;
        let stiffness = &config.structure.stiffness_n_per_m;
        let rig = Rig::new(&test.plant, stiffness, rate_hz, seed)
            .map_err(|e| Failure::input(e.to_string()))?;
        let mut outer = OuterLoop::new(design);
        outer.set_pace(Some(test.serve.pace));
        Ok(Box::new(Simulated::<N> {
            outer,
            rig,
            command_m: [0.0; N],
            target_m: [0.0; N],
            given: 0,
            observed: 0,
            settings: test.serve,
            rate_hz,
            shear_n_per_m: shear_frame(stiffness),
            steps: 0,
            moves: false,
            clock: None,
            ledger: Ledger::default(),
            trace: keep.then(|| Trace::new(N, rate_hz)),
            scope,
        }))
    })
}

/// The stiffness matrix of a shear frame, row by row, from its storeys' stiffnesses.
pub fn shear_frame(storeys: &[f64]) -> Vec<f64> {
    let n = storeys.len();
    let mut matrix = vec![0.0; n * n];
    for (j, k) in storeys.iter().enumerate() {
        matrix[j * n + j] += k;
        if let Some(below) = j.checked_sub(1) {
            matrix[below * n + below] += k;
            matrix[below * n + j] -= k;
            matrix[j * n + below] -= k;
        }
    }
    matrix
}

struct Simulated<const N: usize> {
    outer: OuterLoop<N>,
    rig: Rig,
    command_m: [f64; N],
    target_m: [f32; N],
    /// Targets that were given, and observations that core has made: one at the start, one at each target.
    given: usize,
    observed: usize,
    settings: Settings,
    rate_hz: f64,
    shear_n_per_m: Vec<f64>,
    steps: u64,
    /// A client is being served: a test that ends meanwhile was stopped by a person.
    moves: bool,
    /// Where the pace is the wall clock's: an instant and the step that belonged to it.
    clock: Option<(Instant, u64)>,
    ledger: Ledger,
    trace: Option<Trace>,
    scope: Option<Scope>,
}

impl<const N: usize> Simulated<N> {
    /// One control period: its record, and what the rig showed in it.
    fn step(&mut self) -> Result<(Record<N>, Reached), Stop> {
        let reading = self.rig.step(&self.command_m);
        let mut sample = Sample::new([0.0; N], [0.0; N]);
        for j in 0..N {
            sample.displacement_m[j] = reading.displacement_m[j] as f32;
            sample.force_n[j] = reading.force_n[j] as f32;
        }
        sample.fault = reading.at_rail.then_some(Fault::AdcRail);
        let before = self.outer.state();
        let step = self.outer.step(&sample, &GroundMotion::none());
        self.command_m = step.command_m.map(f64::from);
        let record = *step.record;
        self.steps += 1;
        self.scope.glance(&record);
        // What means nothing in this mode is refused, and nothing happens.
        if let Some(wish) = self.scope.wish() {
            let _ = self.outer.handle(wish);
        }
        if self.outer.state() == Mode::Holding && self.clock.is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        if before.integrates() {
            self.observed += usize::from(record.has(flag::SOLVED));
            self.ledger.see(&record);
            self.trace.see(&record);
        }
        if let Some(trip) = self.outer.trip() {
            return Err(Stop::Tripped(trip));
        }
        if before == Mode::Finished && self.moves {
            return Err(Stop::Operator);
        }
        // What core takes out of a sample is taken out of the reading, which has more digits.
        let better = |reading: f64, estimate: f32, sample: f32| {
            reading + (f64::from(estimate) - f64::from(sample))
        };
        let each = |f: &dyn Fn(usize) -> f64| (0..N).map(f).collect();
        let reached = Reached {
            displacement_m: each(&|j| {
                let estimate = record.estimated_displacement_m[j];
                better(
                    reading.displacement_m[j],
                    estimate,
                    sample.displacement_m[j],
                )
            }),
            force_n: each(&|j| {
                let estimate = record.estimated_force_n[j];
                better(reading.force_n[j], estimate, sample.force_n[j])
            }),
        };
        Ok((record, reached))
    }

    fn event(&mut self, event: Event) -> Result<(), Failure> {
        let refused = |e: outerloop_core::supervise::Rejected| Failure::test(e.to_string());
        self.outer.handle(event).map(drop).map_err(refused)
    }

    /// The test begins with its first target: nothing is late before.
    fn start(&mut self) -> Result<(), Stop> {
        if self.outer.state() == Mode::Armed {
            let lost = |e: Failure| Stop::Lost(e.to_string());
            self.event(Event::Start).map_err(lost)?;
            let paced = self.settings.pace == Pace::Continuous;
            self.clock = paced.then(|| (Instant::now(), self.steps));
        }
        Ok(())
    }

    /// Stands at the target for a while, then means over the next steps.
    fn stand(&mut self) -> Result<Reached, Stop> {
        let in_steps = |ms: f64| (ms * 1e-3 * self.rate_hz).round() as usize;
        // A sample is taken with the command before it.
        let settle = 1 + in_steps(self.settings.settle_ms);
        let average = in_steps(self.settings.average_ms).max(1);
        while self.command_m != self.target_m.map(f64::from) {
            self.step()?;
        }
        for _ in 1..settle {
            self.step()?;
        }
        let mut mean = Reached {
            displacement_m: vec![0.0; N],
            force_n: vec![0.0; N],
        };
        let share = 1.0 / average as f64;
        for _ in 0..average {
            let (_, now) = self.step()?;
            for j in 0..N {
                mean.displacement_m[j] += share * now.displacement_m[j];
                mean.force_n[j] += share * now.force_n[j];
            }
        }
        Ok(mean)
    }

    /// Until the sample at the target has been taken.
    fn pass(&mut self) -> Result<Reached, Stop> {
        loop {
            self.wait_for_the_clock();
            let (_, mut reached) = self.step()?;
            if self.observed > self.given {
                reached.force_n = self.outer.answer_n().map(f64::from).to_vec();
                return Ok(reached);
            }
        }
    }

    /// How many steps the wall clock is ahead.
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

impl<const N: usize> Mover for Simulated<N> {
    fn begin(&mut self) -> Result<(), Failure> {
        let tripped = |stop: Stop| Failure::test(stop.to_string());
        for _ in 0..IDLE_STEPS {
            self.step().map_err(tripped)?;
        }
        (self.ledger, self.given, self.observed) = (Ledger::default(), 0, 0);
        self.event(Event::Arm)?;
        while self.outer.state() != Mode::Armed {
            self.step().map_err(tripped)?;
        }
        Ok(())
    }

    fn go_to(&mut self, target_m: &[f64]) -> Result<Reached, Stop> {
        self.target_m = std::array::from_fn(|j| target_m[j] as f32);
        self.moves = true;
        self.outer.set_next_target(self.target_m);
        self.given += 1;
        self.start()?;
        let mut reached = match self.settings.pace {
            Pace::StopAndGo => {
                // The next step takes the target up.
                self.step()?;
                self.stand()?
            }
            Pace::Continuous => self.pass()?,
        };
        let apart = target_m.iter().zip(&reached.displacement_m);
        let apart: Vec<f64> = apart.map(|(target, now)| now - target).collect();
        self.ledger.reached(target_m, apart.iter().copied());
        if self.settings.pace == Pace::StopAndGo && self.settings.carry_force {
            for j in 0..N {
                for k in 0..N {
                    reached.force_n[j] -= self.shear_n_per_m[j * N + k] * apart[k];
                }
            }
        }
        Ok(reached)
    }

    fn meanwhile(&mut self) -> Result<(), Stop> {
        // Where the rig stands, its time stands, too; but for somebody who looks on.
        if self.clock.is_some() {
            while self.due() >= 1.0 {
                self.step()?;
            }
        } else if self.scope.is_some() && self.moves {
            self.step()?;
        }
        Ok(())
    }

    fn needs_care(&self) -> bool {
        self.settings.pace == Pace::Continuous
    }

    fn end(&mut self) -> Result<(), Failure> {
        (self.clock, self.moves) = (None, false);
        if !matches!(
            self.outer.state(),
            Mode::Idle | Mode::Armed | Mode::Approaching | Mode::Finished | Mode::Tripped
        ) {
            self.event(Event::Stop)?;
        }
        if self.outer.state() == Mode::Finished {
            let mut before = [f64::NAN; N];
            while self.command_m != before && self.outer.state() == Mode::Finished {
                before = self.command_m;
                let _ = self.step();
            }
        }
        match self.outer.state() {
            Mode::Armed | Mode::Approaching => self.event(Event::Stop),
            Mode::Finished | Mode::Tripped => self.event(Event::Clear),
            _ => Ok(()),
        }
    }

    fn permit(&self) -> bool {
        self.outer.state().permits_motion()
    }

    fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    fn take_trace(&mut self) -> Option<Trace> {
        let trace = self.trace.as_mut()?;
        Some(std::mem::replace(trace, Trace::new(N, self.rate_hz)))
    }
}

#[cfg(test)]
mod tests {
    use super::shear_frame;

    #[test]
    fn storeys_make_a_shear_frame() {
        assert_eq!(shear_frame(&[158e3]), [158e3]);
        let two = [5.0, -2.0, -2.0, 2.0];
        assert_eq!(shear_frame(&[3.0, 2.0]), two);
    }
}
