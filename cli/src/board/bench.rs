//! A whole test on a board.

use super::commission::commission;
use super::connection::Connection;
use super::course::Course;
use super::further::Further;
use super::image::{Image, converter_bits};
use super::limits::{self, Plan};
use super::mirror::Mirror;
use super::operator::{Operator, catch_ctrl_c, stop_is_asked};
use super::orders::{clear, done, event, identify, status};
use super::played::Played;
use super::port::Port;
use super::wording::describe_words;
use crate::bench::{Assignment, Bench, Ending, OnBoard};
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::trace::Witness;
use link::Command;
use link::command::{CHUNK, MAX_POINTS};
use link::frame::checksum;
use link::limits::Shown;
use link::reply::Identity;
use link::telemetry::StepReport;
use outerloop_core::{Config, Design, Event, Fault, GroundMotion, Record, State, Trip};
use std::cell::RefCell;
use std::time::Instant;

/// Steps before arming: the loop averages where the specimen stands.
const IDLE_STEPS: u64 = 256;

/// Steps for which the command has to stand after the end.
const REST_STEPS: u32 = 40;

/// A board at the other end of a connection.
pub struct BoardBench<P> {
    connection: RefCell<Connection<P>>,
    plan: Plan,
    operator: Operator,
    /// The number that the board's calibration has to have.
    calibration: Option<String>,
    /// The bits that its converters have to have.
    bits: Option<u8>,
}

impl<P: Port> BoardBench<P> {
    /// Over `connection`, for tests that are planned as `plan` says; `operator` is asked before each starts.
    pub fn new(connection: Connection<P>, plan: Plan, operator: Operator) -> Self {
        Self {
            connection: RefCell::new(connection),
            plan,
            operator,
            calibration: None,
            bits: None,
        }
    }

    /// On a board whose calibration has this number, eight hexadecimal digits.
    pub fn expecting(mut self, calibration: Option<String>) -> Self {
        self.calibration = calibration;
        self
    }

    /// On a board whose converters have so many bits.
    pub fn with_bits(mut self, bits: Option<u8>) -> Self {
        self.bits = bits;
        self
    }

    /// Moves the actuator by `course` on the same board; see [`commission`].
    ///
    /// # Errors
    /// Those of [`commission`].
    pub fn play(
        &self,
        test: &TestFile,
        course: &Course,
        witness: &mut impl Witness,
    ) -> Result<Played, Failure> {
        let board = &mut *self.connection.borrow_mut();
        commission(board, test, course, &self.operator, witness)
    }

    /// The connection back.
    pub fn into_connection(self) -> Connection<P> {
        self.connection.into_inner()
    }

    /// The board's converters and calibration are those that the test names.
    fn check_board(&self, identity: &Identity) -> Result<(), Failure> {
        let bits = converter_bits(&identity.codes);
        if let Some(wanted) = self.bits.filter(|b| u32::from(*b) != bits) {
            return Err(Failure::input(format!(
                "board.converter_bits = {wanted}: the board's converters have {bits} bits: accepted is the image for the converters that the test asks for ({} for 16 bits)",
                Image::External.name()
            )));
        }
        let number = format!("{:08x}", identity.calibration.number());
        match &self.calibration {
            Some(wanted) if !wanted.eq_ignore_ascii_case(&number) => Err(Failure::input(format!(
                "board.calibration = \"{wanted}\": the board's calibration has the number {number}: accepted is the board as it was calibrated for this test; `outerloop board calibrate` shows its lines"
            ))),
            _ => Ok(()),
        }
    }

    /// The configuration with all limits that a board asks for; those that were worked out are shown to the person.
    fn with_limits(&self, config: &Config, identity: &Identity) -> Result<Config, Failure> {
        let shown = Shown::by(&identity.calibration, &identity.codes);
        let mut limited = config.clone();
        limited.limits = self.plan.limits(&config.limits, &shown);
        if limited.limits != config.limits {
            eprintln!(
                "outerloop: limits in force:\n{}",
                limits::describe(&config.limits, &limited.limits)
            );
        }
        shown.check(&limited).map_err(|refusal| {
            let value = match refusal.value {
                value if value.is_nan() => String::new(),
                value => format!(" = {value:.4}"),
            };
            Failure::input(format!(
                "{}{value} cannot act on this board: accepted is {}; it shows +-{:.1} mm and +-{:.2} kN with the spare codes left free",
                refusal.name,
                refusal.accepted,
                shown.displacement_m * 1e3,
                shown.force_n * 1e-3
            ))
        })?;
        Ok(limited)
    }
}

impl<P: Port> Bench for BoardBench<P> {
    fn run<const N: usize>(
        &self,
        assignment: &Assignment<'_, N>,
        witness: &mut impl Witness,
    ) -> Result<Ending, Failure> {
        let points = points(assignment)?;
        let board = &mut *self.connection.borrow_mut();
        let identity = identify(board)?;
        prepare(board)?;
        self.check_board(&identity)?;
        let config = self.with_limits(assignment.config, &identity)?;
        let design = Design::new(&config).map_err(|e| Failure::input(e.to_string()))?;
        let since = done(board, "configure", &Command::Configure(config.clone()))?;
        load(board, points, assignment.interval_s)?;
        done(board, "signal", &Command::Signal(None))?;

        let step_s = config.model_step_s();
        let ground = GroundMotion::new(points, assignment.interval_s, step_s).ok_or_else(|| {
            Failure::input("the ground motion cannot be laid over the integration steps")
        })?;
        let mirror = Mirror::new(
            design,
            u32::from(config.timing.substeps),
            ground,
            (identity.calibration, identity.codes),
            since,
        );
        catch_ctrl_c();
        let mut session = Session::<P, N>::new(board, mirror, since);
        session.wait_idle()?;
        session.send(Event::Arm)?;
        session.wait_for_start()?;
        session.wait_for_go(&self.operator)?;
        let began = Instant::now();
        session.send(Event::Start)?;
        session.run(assignment.steps, witness, began, &identity, &self.operator)
    }
}

/// The points of the ground motion that the test needs.
fn points<'a, const N: usize>(assignment: &Assignment<'a, N>) -> Result<&'a [f32], Failure> {
    let config = assignment.config;
    let seconds = assignment.steps as f64 / config.timing.rate_hz / config.timing.time_scale;
    let needed = (seconds / assignment.interval_s).ceil() as usize + 2;
    let all = assignment.points_m_per_s2;
    let points = all.get(..needed).unwrap_or(all);
    if points.len() > MAX_POINTS {
        return Err(Failure::input(format!(
            "the ground motion has {} points in {seconds} s: accepted on a board are up to {MAX_POINTS}; a --duration, or fewer points a second",
            points.len()
        )));
    }
    Ok(points)
}

/// An idle board, or why it is none.
fn prepare<P: Port>(board: &mut Connection<P>) -> Result<(), Failure> {
    let now = status(board)?;
    if let Some(said) = describe_words(now.started, now.last_words.as_ref()) {
        eprintln!("outerloop: note: {said}");
    }
    match (now.state, now.trip) {
        (State::Idle, _) => Ok(()),
        (State::Finished, _) => clear(board),
        (State::Tripped, Some(trip)) => Err(Failure::test(format!(
            "the board stands tripped on {}: accepted is an idle board; look, then `outerloop board clear`",
            trip.fault.name()
        ))),
        (state, _) => Err(Failure::test(format!(
            "the board is {}: accepted is an idle board",
            state.name()
        ))),
    }
}

/// Sends the ground motion, or points of a signal.
pub(super) fn load<P: Port>(
    board: &mut Connection<P>,
    points: &[f32],
    interval_s: f64,
) -> Result<(), Failure> {
    let announce = Command::Motion {
        points: points.len() as u32,
        interval_s,
        checksum: checksum(points.iter().flat_map(|p| p.to_le_bytes())),
    };
    done(board, "ground motion", &announce)?;
    for (first, chunk) in (0_u32..).step_by(CHUNK).zip(points.chunks(CHUNK)) {
        let points = chunk.iter().copied().collect();
        done(board, "ground motion", &Command::Points { first, points })?;
    }
    Ok(())
}

/// A test from its configuration to its end.
struct Session<'a, 'b, P, const N: usize> {
    board: &'b mut Connection<P>,
    mirror: Mirror<'a, N>,
    since: u32,
    state: State,
    command_m: f32,
    /// Steps seen since the test is in force.
    steps: u64,
    /// Steps lost, by the connection's count, before the test was in force.
    lost_before: u64,
}

impl<'a, 'b, P: Port, const N: usize> Session<'a, 'b, P, N> {
    fn new(board: &'b mut Connection<P>, mirror: Mirror<'a, N>, since: u32) -> Self {
        Self {
            lost_before: board.counted().1,
            board,
            mirror,
            since,
            state: State::Idle,
            command_m: f32::NAN,
            steps: 0,
        }
    }

    fn send(&mut self, what: Event) -> Result<(), Failure> {
        let tick = event(self.board, what)?;
        self.mirror.event(tick, what);
        Ok(())
    }

    /// Ends the test. Telemetry comes some steps late: a board that has ended by itself since has nothing to refuse.
    fn end(&mut self, by: Event) -> Result<(), Failure> {
        match self.send(by) {
            Err(refused) => match status(self.board)?.state {
                State::Finished | State::Tripped => Ok(()),
                _ => Err(refused),
            },
            sent => sent,
        }
    }

    /// The next step of the test that is in force.
    fn next(&mut self) -> Result<(u32, StepReport), Failure> {
        loop {
            let Some((tick, step)) = self.board.step()? else {
                continue;
            };
            if tick.wrapping_sub(self.since) < u32::MAX / 2 {
                self.state = step.state().unwrap_or(self.state);
                self.command_m = step.command_m;
                self.steps += 1;
                return Ok((tick, step));
            }
        }
    }

    fn wait_idle(&mut self) -> Result<(), Failure> {
        while self.steps < IDLE_STEPS {
            let (tick, step) = self.next()?;
            self.mirror.take(tick, step);
        }
        Ok(())
    }

    /// Until the approach to the start position has ended.
    fn wait_for_start(&mut self) -> Result<(), Failure> {
        loop {
            let (tick, step) = self.next()?;
            self.mirror.take(tick, step);
            match self.state {
                State::Armed if self.command_m == 0.0 => return Ok(()),
                // Telemetry of the steps before arming is behind us: the board's button has ended the approach.
                State::Idle if self.mirror.has_armed() => {
                    return Err(Failure::test(
                        "the approach to the start was ended by the board's button, and the board is idle",
                    ));
                }
                State::Tripped => {
                    let trip = status(self.board)?.trip;
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
    fn wait_for_go(&mut self, operator: &Operator) -> Result<(), Failure> {
        operator
            .ask("the rig stands at the start, armed: Enter starts the test, Ctrl-C gives it up");
        while !operator.agrees() {
            if stop_is_asked() {
                self.send(Event::Stop)?;
                self.until_still()?;
                return Err(Failure::test("the test was given up before its start"));
            }
            let (tick, step) = self.next()?;
            self.mirror.take(tick, step);
            if self.state == State::Tripped {
                let fault = status(self.board)?
                    .trip
                    .map_or("a fault", |t| t.fault.name());
                return Err(Failure::test(format!(
                    "the board tripped on {fault} before the start: see `outerloop board status`"
                )));
            }
        }
        Ok(())
    }

    /// Until the command stands: the test has ended, and the deceleration ramp with it. Only then may permission go.
    fn wait_for_rest(&mut self) -> Result<(), Failure> {
        let (mut standing, mut last_m) = (0, f32::NAN);
        while standing < REST_STEPS && self.state == State::Finished {
            self.next()?;
            standing = if self.command_m == last_m {
                standing + 1
            } else {
                0
            };
            last_m = self.command_m;
        }
        Ok(())
    }

    /// Until the board has come to rest by itself, and is idle then.
    fn until_still(&mut self) -> Result<(), Failure> {
        while !matches!(self.state, State::Idle | State::Finished | State::Tripped) {
            let (tick, step) = self.next()?;
            self.mirror.take(tick, step);
        }
        if self.state == State::Finished {
            clear(self.board)?;
        }
        Ok(())
    }

    /// Somebody who looks on wants something. What the board refuses by now does not happen, and nothing is lost.
    fn ask_for(&mut self, wish: Event) -> Result<(), Failure> {
        match self.send(wish) {
            Err(_) if self.state.after(wish).is_err() => Ok(()),
            sent => sent,
        }
    }

    fn run(
        mut self,
        steps: usize,
        witness: &mut impl Witness,
        began: Instant,
        identity: &Identity,
        operator: &Operator,
    ) -> Result<Ending, Failure> {
        let mut done = 0;
        let mut lost = None;
        let mut further = Further::of(identity);
        let (mut stopped, mut held, mut by_hand) = (false, false, false);
        // Steps count by their number, not by their coming: some may be lost on the way. Those of a hold do not count.
        let (mut first, mut last_running, mut in_hold) = (None, 0, 0);
        let mut see = |record: Option<Record<N>>| {
            let running = |r: &Record<N>| r.mode().is_some_and(State::integrates);
            let held = |r: &Record<N>| matches!(r.mode(), Some(State::Holding | State::Returning));
            if let Some(record) = record.as_ref().filter(|r| held(r)) {
                in_hold = record.tick.wrapping_sub(last_running);
            }
            if let Some(record) = record.as_ref().filter(|r| running(r)) {
                let first = first.get_or_insert(record.tick);
                *first = first.wrapping_add(std::mem::take(&mut in_hold));
                last_running = record.tick;
                done = record.tick.wrapping_sub(*first) as usize + 1;
                if done <= steps {
                    witness.see(record);
                }
            } else if let Some(record) = record {
                witness.glance(&record);
            }
            (done, witness.wish())
        };
        let ended = loop {
            match self.next() {
                Ok((tick, step)) => {
                    if let Some(further) = further.as_mut().filter(|_| self.state.integrates()) {
                        further.see(tick, &step);
                    }
                    let (done, wish) = see(self.mirror.take(tick, step));
                    match wish {
                        Some(Event::Stop) if !stopped => {
                            stopped = true;
                            self.end(Event::Stop)?;
                            by_hand = true;
                        }
                        Some(wish) if !stopped => self.ask_for(wish)?,
                        _ => {}
                    }
                    // The record on the board is at most some steps longer than the test.
                    if done >= steps && self.state.integrates() && !stopped {
                        stopped = true;
                        self.end(Event::Finish)?;
                    }
                }
                Err(failure) => {
                    lost = Some(failure.to_string());
                    break State::Tripped;
                }
            }
            if matches!(self.state, State::Finished | State::Tripped) {
                break self.state;
            }
            if stop_is_asked() && !stopped {
                stopped = true;
                self.end(Event::Stop)?;
                by_hand = true;
            }
            // The board's button has held the test.
            let holds = self.state == State::Holding && !stopped;
            if holds && !std::mem::replace(&mut held, holds) {
                operator.ask("the test is held: Enter goes on, Ctrl-C stops");
            }
            if holds && operator.is_asked() && operator.agrees() {
                self.send(Event::Start)?;
            }
            held = holds;
        };
        let (done_steps, _) = see(self.mirror.last());
        let wall_s = began.elapsed().as_secs_f64();
        let vitals = match &lost {
            None => Some(status(self.board)?),
            Some(_) => None,
        };
        let trip = match (&vitals, ended) {
            (Some(status), State::Tripped) => status.trip,
            (None, _) => Some(Trip {
                fault: Fault::LinkLost,
                axis: 0,
                value: f32::NAN,
                limit: f32::NAN,
                tick: 0,
            }),
            _ => None,
        };
        if ended == State::Finished {
            self.wait_for_rest()?;
            clear(self.board)?;
        }
        if by_hand && done_steps < steps {
            return Err(Failure::test(format!(
                "the test was stopped by hand after {done_steps} of {steps} control steps: it came to rest on its deceleration ramp, and the board is idle"
            )));
        }
        let seen = self.mirror.seen();
        Ok(Ending {
            state: ended,
            trip,
            wall_s,
            board: Some(OnBoard {
                board: identity.board.as_str().to_owned(),
                commit: identity.commit.as_str().to_owned(),
                steps_received: seen.proven + seen.different,
                steps_lost: self.board.counted().1 - self.lost_before,
                steps_dropped: vitals.as_ref().map(|v| v.dropped_steps),
                steps_different: seen.different,
                timing: vitals.as_ref().map(|v| v.timing),
                clock_hz: identity.clock_hz,
                link: lost,
                further,
                trip: trip.map(|t| t.fault),
            }),
        })
    }
}
