//! A test in force on a board: its events with the steps at which they were taken, and every step, recomputed on the PC.
//! Used both for a test on a ground motion and for a rig that serves an external model.

use super::connection::Connection;
use super::mirror::Mirror;
use super::operator::Operator;
use super::orders::{clear, done, event, started_again, status};
use super::port::Port;
use super::standing::Standing;
use crate::terminal::interrupt;
use experiment::bench::interface::OnBoard;
use experiment::bench::{FurtherInputs, IDLE_STEPS};
use experiment::failure::Failure;
use experiment::trace::TestObserver;
use link::Command;
use link::MAX_ACTUATORS;
use link::continuity::Ticks;
use link::reply::Identity;
use link::status::Status;
use link::telemetry::StepReport;
use outerloop_core::watch::Instructions;
use outerloop_core::{Config, DirectRig, Event, Fault, Mode, Record, Rig};

/// Steps for which the commands must stand still after the end. The second applies where the PC knows only the first
/// command: longer than any ramp, which takes at most 2 s.
const REST_STEPS: u32 = 40;
const UNSEEN_REST_STEPS: u32 = 10_000;

/// A test from its configuration to its end.
pub struct ConfiguredTest<'a, const N: usize, R: Rig<N> = DirectRig<N>> {
    mirror: Mirror<'a, N, R>,
    since: u32,
    mode: Mode,
    command_m: f32,
    /// The fault reported by the board.
    fault: Option<Fault>,
    /// Steps seen since the test came into force.
    steps: u64,
    ticks: Ticks,
    /// Steps that the connection had lost before the test came into force.
    lost_before: u64,
    /// The board's button holds the test, and somebody has been told.
    held: bool,
    /// Further inputs that the board records during the test.
    further: Option<FurtherInputs>,
    /// The latest step. Its record is computed when the next one has come.
    latest: Option<(u32, StepReport)>,
}

impl<'a, const N: usize, R: Rig<N>> ConfiguredTest<'a, N, R> {
    /// A test that is in force on `board` from step `since` on; the board is `identity`.
    pub fn new<P: Port>(
        board: &Connection<P>,
        mirror: Mirror<'a, N, R>,
        since: u32,
        identity: &Identity,
    ) -> Self {
        Self {
            further: FurtherInputs::of(identity),
            latest: None,
            lost_before: board.counted().1,
            mirror,
            since,
            mode: Mode::Idle,
            command_m: f32::NAN,
            fault: None,
            held: false,
            steps: 0,
            ticks: Ticks::new(),
        }
    }

    /// The loop's mode in the last step.
    pub fn mode(&self) -> Mode {
        self.mode
    }

    /// Steps seen since the test came into force.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The fault on which the board tripped, from its telemetry.
    pub fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// The loop on the PC.
    pub fn mirror(&self) -> &Mirror<'a, N, R> {
        &self.mirror
    }

    /// Sends an event.
    ///
    /// # Errors
    /// A lost link; an event that is refused.
    pub fn send<P: Port>(&mut self, board: &mut Connection<P>, what: Event) -> Result<(), Failure> {
        let tick = event(board, what)?;
        self.mirror.event(tick, what);
        Ok(())
    }

    /// Has the board watch the test, with the instructions `told` for each actuator.
    ///
    /// # Errors
    /// As [`done`]; an instruction that the board's watch cannot take.
    pub fn watch<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        told: Vec<Instructions>,
    ) -> Result<(), Failure> {
        let corrects = told.iter().any(Instructions::corrects);
        let mut since = None;
        for (actuator, told) in (0..).zip(told) {
            since = Some(done(board, "watch", &Command::Watch(actuator, told))?);
        }
        if let Some(tick) = since {
            self.mirror.watch(tick, corrects);
        }
        Ok(())
    }

    /// Has `observer` judge the blocks of the board's rig watch.
    pub fn be_judged(&mut self, observer: &mut dyn TestObserver) {
        self.mirror.be_judged(observer);
    }

    /// Sends the next target of each actuator, m.
    ///
    /// # Errors
    /// A lost link; a target that is refused.
    pub fn aim<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        target_m: [f32; N],
    ) -> Result<(), Failure> {
        // A board has no more actuators than a target has room for, and the test has as many as the board.
        let targets = target_m.into_iter().take(MAX_ACTUATORS).collect();
        let tick = done(board, "target", &Command::Target(targets))?;
        self.mirror.target(tick, target_m);
        Ok(())
    }

    /// Ends the test. Telemetry comes some steps late: if the board has already ended, a refusal is no error, and if its
    /// button holds it, it is stopped.
    ///
    /// # Errors
    /// As [`ConfiguredTest::send`].
    pub fn end<P: Port>(&mut self, board: &mut Connection<P>, by: Event) -> Result<(), Failure> {
        match self.send(board, by) {
            Err(refused) => match status(board)?.mode {
                Mode::Finished | Mode::Stopping | Mode::Tripped => Ok(()),
                Mode::Holding if by == Event::Finish => self.end(board, Event::Stop),
                _ => Err(refused),
            },
            sent => sent,
        }
    }

    /// True if a received step belongs to the test in force. Fails if the board has restarted.
    fn note<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        tick: u32,
        step: &StepReport,
    ) -> Result<bool, Failure> {
        if self.ticks.take(tick).is_none() {
            // It has no test any more, and nothing has to come to rest.
            self.mode = Mode::Idle;
            return Err(started_again(board));
        }
        let ours = tick.wrapping_sub(self.since) < u32::MAX / 2;
        if ours {
            self.mode = step.mode().unwrap_or(self.mode);
            self.command_m = step.command_m;
            self.fault = step.fault();
            self.steps += 1;
        }
        Ok(ours)
    }

    /// Computes the record of the previous step, and adds the further inputs recorded in it.
    fn take(&mut self, tick: u32, step: StepReport) -> Option<Record<N>> {
        let before = self.latest.replace((tick, step));
        let record = self.mirror.take(tick, step)?;
        self.add_further_inputs(before, &record);
        Some(record)
    }

    fn add_further_inputs(&mut self, step: Option<(u32, StepReport)>, record: &Record<N>) {
        let (Some(further), Some((tick, step))) = (&mut self.further, step) else {
            return;
        };
        if step.mode().is_some_and(Mode::integrates) {
            // For a step that could not be recomputed the telemetry has the target, but not what a predictor sent for it.
            let known = if self.mirror.is_in_step() { N } else { 0 };
            further.add_step(tick, &record.sent_m[..known], &step);
        }
    }

    /// Receives the next step of the test in force and gives the record of the one before it; `None` at the first step, or if
    /// none has come for some milliseconds.
    ///
    /// # Errors
    /// A lost link; a board that has restarted.
    pub fn next<P: Port>(
        &mut self,
        board: &mut Connection<P>,
    ) -> Result<Option<Record<N>>, Failure> {
        while let Some((tick, step)) = board.step()? {
            if self.note(board, tick, &step)? {
                return Ok(self.take(tick, step));
            }
        }
        Ok(None)
    }

    /// The records of all steps received so far; waits some milliseconds if there are none.
    ///
    /// # Errors
    /// As [`ConfiguredTest::next`].
    pub fn come<P: Port>(&mut self, board: &mut Connection<P>) -> Result<Vec<Record<N>>, Failure> {
        let mut records = Vec::new();
        for (tick, step) in board.steps()? {
            if self.note(board, tick, &step)? {
                records.extend(self.take(tick, step));
            }
        }
        Ok(records)
    }

    /// The record of the last step, when no more will come.
    pub fn last(&mut self) -> Option<Record<N>> {
        let record = self.mirror.last()?;
        let latest = self.latest.take();
        self.add_further_inputs(latest, &record);
        Some(record)
    }

    /// Idle steps, then the person's word that the rig stands where `config` assumes, then arming and the approach to the
    /// start position, which Ctrl-C ends.
    ///
    /// # Errors
    /// A person who gives up; a board that does not arm, that trips during the approach, or whose button has ended it.
    pub fn arm<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        identity: &Identity,
        operator: &Operator,
        config: &Config,
    ) -> Result<(), Failure> {
        while self.steps < IDLE_STEPS as u64 {
            self.next(board)?;
        }
        let mut asked = false;
        loop {
            if let Some((_, step)) = &self.latest {
                let standing = Standing::of(identity, N, step, config);
                if !std::mem::replace(&mut asked, true) {
                    operator.ask(&standing.question());
                }
                if operator.lets_arm(&standing)? {
                    break;
                }
            }
            if interrupt::asked() {
                return Err(Failure::test("the test was given up before anything moved"));
            }
            self.next(board)?;
        }
        self.send(board, Event::Arm)?;
        loop {
            self.next(board)?;
            if interrupt::asked() {
                self.ask_for(board, Event::Stop)?;
                let now = status(board)?.mode.name();
                return Err(Failure::test(format!(
                    "the approach to the start was given up, and the board is {now}"
                )));
            }
            match self.mode {
                Mode::Armed if self.command_m == 0.0 => return Ok(()),
                // Telemetry of the steps before arming has all been read: the board's button has ended the approach.
                Mode::Idle if self.mirror.has_armed() => {
                    return Err(Failure::test(
                        "the approach to the start was ended by the board's button, and the board is idle",
                    ));
                }
                Mode::Tripped => {
                    let trip = status(board)?.trip;
                    let fault = trip.map_or("an unknown fault", |t| t.fault.name());
                    return Err(Failure::test(format!(
                        "the board tripped on {fault} on its way to the start position: accepted is a rig that reaches zero within its limits"
                    )));
                }
                _ => {}
            }
        }
    }

    /// The rig stands at the start, armed. It moves when the person says so.
    ///
    /// # Errors
    /// A person who gives the test up; a step that could not be recomputed; a board that trips, or whose button has ended
    /// the test.
    pub fn wait_for_go<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        operator: &Operator,
    ) -> Result<(), Failure> {
        operator
            .ask("the rig stands at the start, armed: Enter starts the test, Ctrl-C gives it up");
        loop {
            let asked = match self.mirror.is_in_step() {
                true => operator.lets_start("the test was given up before its start"),
                false => Err(Failure::test(
                    "what the board does could not be worked out again before the start, as it is where steps are lost on their way: \
                     the test was given up; accepted is a PC that keeps up with the board, not one that sleeps",
                )),
            };
            match asked {
                Ok(true) => return Ok(()),
                Ok(false) => {}
                Err(why) => {
                    self.send(board, Event::Stop)?;
                    self.until_still(board)?;
                    return Err(why);
                }
            }
            self.next(board)?;
            if self.mode == Mode::Idle {
                return Err(Failure::test(
                    "the test was ended before its start by the board's button, and the board is idle",
                ));
            }
            if self.mode == Mode::Tripped {
                let fault = status(board)?.trip.map_or("a fault", |t| t.fault.name());
                return Err(Failure::test(format!(
                    "the board tripped on {fault} before the start: see `outerloop board status`"
                )));
            }
        }
    }

    /// Starts the armed test. If the board refuses, it does not stay armed.
    ///
    /// # Errors
    /// As [`ConfiguredTest::send`].
    pub fn start<P: Port>(&mut self, board: &mut Connection<P>) -> Result<(), Failure> {
        let started = self.send(board, Event::Start);
        if started.is_err() {
            self.ask_for(board, Event::Stop)?;
            self.until_still(board)?;
        }
        started
    }

    /// Says once that the board's button holds the test; true if somebody who can be asked then agrees to resume it.
    ///
    /// # Errors
    /// As [`Operator::agrees`].
    pub fn is_to_go_on(&mut self, operator: &Operator) -> Result<bool, Failure> {
        let holds = self.mode == Mode::Holding;
        if !std::mem::replace(&mut self.held, holds) && holds {
            operator.ask_to_go_on();
        }
        Ok(holds && operator.is_asked() && operator.agrees()?)
    }

    /// Resumes after a hold. A board whose button is still pressed refuses, and the person is asked again.
    ///
    /// # Errors
    /// As [`ConfiguredTest::ask_for`].
    pub fn go_on<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        operator: &Operator,
    ) -> Result<(), Failure> {
        let Err(refused) = self.ask_for(board, Event::Start) else {
            return Ok(());
        };
        if status(board)?.mode != Mode::Holding {
            return Err(refused);
        }
        eprintln!("outerloop: {refused}");
        operator.ask_to_go_on();
        Ok(())
    }

    /// Waits from the end of a test until every command stands still: the deceleration ramp is over, and PERMIT may fall.
    /// A finished board is then made idle; one that has tripped stays tripped, for somebody to look.
    ///
    /// # Errors
    /// As [`ConfiguredTest::next`]; a board that cannot be cleared.
    pub fn come_to_rest<P: Port>(&mut self, board: &mut Connection<P>) -> Result<(), Failure> {
        let (mut standing, mut last_m) = (0, [f32::NAN; N]);
        while matches!(self.mode, Mode::Finished | Mode::Stopping) {
            let steps = if N == 1 || self.mirror.is_in_step() {
                REST_STEPS
            } else {
                UNSEEN_REST_STEPS
            };
            if self.mode == Mode::Finished && standing >= steps {
                return clear(board);
            }
            let Some(record) = self.next(board)? else {
                continue;
            };
            // An unknown command of a lost step counts as standing still.
            let known_m = record.command_m.map(|m| if m.is_nan() { 0.0 } else { m });
            standing = if known_m == last_m { standing + 1 } else { 0 };
            last_m = known_m;
        }
        Ok(())
    }

    /// Waits until the board has come to rest by itself, then makes it idle unless it tripped.
    ///
    /// # Errors
    /// A lost link; a board that cannot be cleared.
    pub fn until_still<P: Port>(&mut self, board: &mut Connection<P>) -> Result<(), Failure> {
        while !matches!(self.mode, Mode::Idle | Mode::Finished | Mode::Tripped) {
            self.next(board)?;
        }
        self.come_to_rest(board)
    }

    /// Sends an event that somebody requested. Telemetry comes some steps late: if the event no longer applies in the
    /// board's present mode, it is dropped without an error.
    ///
    /// # Errors
    /// As [`ConfiguredTest::send`], if the event still applies.
    pub fn ask_for<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        event: Event,
    ) -> Result<(), Failure> {
        match self.send(board, event) {
            Err(refused) => match status(board)?.mode.after(event) {
                Err(_) => Ok(()),
                Ok(_) => Err(refused),
            },
            sent => sent,
        }
    }

    /// What the board reports about the test. Call once. `link`: why the link was lost; `trip`: the fault it tripped on.
    pub fn account<P: Port>(
        &mut self,
        board: &Connection<P>,
        identity: &Identity,
        board_status: Option<&Status>,
        link: Option<String>,
        trip: Option<Fault>,
    ) -> OnBoard {
        let seen = self.mirror.seen();
        OnBoard {
            board: identity.board.as_str().to_owned(),
            commit: identity.commit.as_str().to_owned(),
            steps_received: seen.proven + seen.different,
            steps_lost: board.counted().1 - self.lost_before,
            steps_dropped: board_status.map(|v| v.dropped_steps),
            steps_different: seen.different,
            timing: board_status.map(|v| v.timing),
            clock_hz: identity.clock_hz,
            link,
            further: self.further.take(),
            trip,
        }
    }
}
