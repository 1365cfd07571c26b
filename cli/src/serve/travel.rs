//! How a rig moves from target to target: stop and go, or continuously.

use super::element::declared_stiffness;
use super::ledger::Ledger;
use super::mover::{Mover, Stop, TargetMeasurement};
use super::served_rig::{ServedRig, ServedStep};
use crate::scope::Scope;
use crate::terminal::interrupt;
use experiment::bench::OnBoard;
use experiment::failure::Failure;
use experiment::files::serve::Settings;
use experiment::files::test::TestFile;
use experiment::trace::AnyRecord;
use experiment::trace::{TestObserver, Trace};
use outerloop_core::{Mode, Pace, flag};

/// A moving rig and its observers.
pub struct Travel<const N: usize, R> {
    rig: R,
    settings: Settings,
    rate_hz: f64,
    /// A record without a step.
    nothing: Trace,
    /// Declared stiffness, row by row.
    stiffness: Vec<f64>,
    /// Targets given, and observations that core has made: one at the start, one at each target.
    given: usize,
    observed: usize,
    /// A client is being served: if the test ends now, a person stopped it.
    moves: bool,
    ledger: Ledger,
    trace: Option<Trace>,
    scope: Option<Scope>,
}

impl<const N: usize, R: ServedRig<N>> Travel<N, R> {
    /// With `rig` and the settings of `test`. `keep`: every step is kept.
    pub fn new(rig: R, test: &TestFile, keep: bool, scope: Option<Scope>) -> Self {
        let rate_hz = test.config.timing.rate_hz;
        Self {
            rig,
            settings: test.serve,
            rate_hz,
            stiffness: declared_stiffness(test),
            given: 0,
            observed: 0,
            moves: false,
            ledger: Ledger::default(),
            trace: keep.then(|| test.trace()),
            nothing: test.trace(),
            scope,
        }
    }

    fn step(&mut self) -> Result<ServedStep<N>, Stop> {
        if interrupt::asked() {
            return Err(Stop::Operator);
        }
        let seen = self.rig.step()?;
        self.observe_step(&seen)?;
        Ok(seen)
    }

    /// Counts a step and shows it to the observers.
    fn observe_step(&mut self, seen: &ServedStep<N>) -> Result<(), Stop> {
        let record = &AnyRecord {
            coupled: seen.coupled.as_ref(),
            ..AnyRecord::from(&seen.record)
        };
        self.scope.on_idle_step(record);
        self.take_scope_request()?;
        if record.mode().is_some_and(Mode::integrates) {
            self.observed += usize::from(record.has(flag::SOLVED));
            self.ledger.on_step(record);
            self.trace.on_step(record);
        }
        match &seen.ended {
            Some(why) if self.moves => Err(why.clone()),
            _ if self.moves && record.mode() == Some(Mode::Finished) => Err(Stop::Operator),
            _ => Ok(()),
        }
    }

    fn take_scope_request(&mut self) -> Result<(), Stop> {
        self.scope
            .requested_event()
            .map_or(Ok(()), |event| self.rig.request(event))
    }

    /// Waits at the target until the rig has settled, then averages over the next steps.
    fn stand(&mut self, target_m: [f32; N]) -> Result<TargetMeasurement, Stop> {
        let in_steps = |ms: f64| (ms * 1e-3 * self.rate_hz).round() as usize;
        let settle = in_steps(self.settings.settle_ms);
        let average = in_steps(self.settings.average_ms).max(1);
        // Waits for a step whose sample was taken with the command at the target.
        let mut now = self.step()?;
        while now.record.command_m != target_m || !now.record.mode().is_some_and(Mode::integrates) {
            if now.record.command_m.iter().any(|m| m.is_nan()) {
                return Err(Stop::Lost(
                    "a step was lost between the board and the PC, and with it where the other actuators are sent".into(),
                ));
            }
            now = self.step()?;
        }
        for _ in 0..settle {
            now = self.step()?;
        }
        let mut mean = TargetMeasurement {
            displacement_m: vec![0.0; N],
            force_n: vec![0.0; N],
        };
        let share = 1.0 / average as f64;
        for place in 0..average {
            if place > 0 {
                now = self.step()?;
            }
            for j in 0..N {
                mean.displacement_m[j] += share * now.reached.displacement_m[j];
                mean.force_n[j] += share * now.reached.force_n[j];
            }
        }
        Ok(mean)
    }

    /// Waits until the sample at the target has been taken.
    fn pass(&mut self) -> Result<TargetMeasurement, Stop> {
        loop {
            let mut seen = self.step()?;
            // A lost step may have been the awaited one.
            let answer_n = self.rig.answer_n()?;
            if self.observed > self.given {
                seen.reached.force_n = answer_n.map(f64::from).to_vec();
                return Ok(seen.reached);
            }
        }
    }
}

impl<const N: usize, R: ServedRig<N>> Mover for Travel<N, R> {
    fn begin(&mut self) -> Result<(), Failure> {
        (self.ledger, self.given, self.observed) = (Ledger::default(), 0, 0);
        self.rig.begin()
    }

    fn go_to(&mut self, target_m: &[f64]) -> Result<TargetMeasurement, Stop> {
        let single_m = std::array::from_fn(|j| target_m[j] as f32);
        self.moves = true;
        self.given += 1;
        self.rig.aim(single_m)?;
        let mut reached = match self.settings.pace {
            Pace::StopAndGo => self.stand(single_m)?,
            Pace::Continuous => self.pass()?,
        };
        let apart = target_m.iter().zip(&reached.displacement_m);
        let apart: Vec<f64> = apart.map(|(target, now)| now - target).collect();
        self.ledger.reached(target_m, &apart);
        if self.settings.pace == Pace::StopAndGo && self.settings.carry_force {
            for j in 0..N {
                for k in 0..N {
                    reached.force_n[j] -= self.stiffness[j * N + k] * apart[k];
                }
            }
        }
        Ok(reached)
    }

    fn meanwhile(&mut self) -> Result<(), Stop> {
        for seen in self.rig.meanwhile()? {
            self.observe_step(&seen)?;
        }
        self.take_scope_request()?;
        // The rig's time stands still between targets, unless somebody watches it.
        if !self.rig.has_own_time() && self.scope.is_some() && self.moves {
            self.step()?;
        }
        Ok(())
    }

    fn needs_care(&self) -> bool {
        self.rig.has_own_time()
    }

    fn end(&mut self) -> Result<(), Failure> {
        self.moves = false;
        self.rig.end()
    }

    fn permit(&self) -> bool {
        self.rig.permit()
    }

    fn ledger(&self) -> &Ledger {
        &self.ledger
    }

    fn take_trace(&mut self) -> Option<Trace> {
        let trace = self.trace.as_mut()?;
        Some(std::mem::replace(trace, self.nothing.clone()))
    }

    fn on_board(&self) -> Option<OnBoard> {
        self.rig.on_board()
    }
}
