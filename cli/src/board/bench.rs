//! A whole test on a board.

use super::connection::Connection;
use super::mirror::Mirror;
use super::orders::{clear, done, event, identify, status};
use super::port::Port;
use super::wording::describe_words;
use crate::bench::{Assignment, Bench, Ending, OnBoard};
use crate::failure::Failure;
use crate::trace::Witness;
use link::Command;
use link::command::{CHUNK, MAX_POINTS};
use link::frame::checksum;
use link::reply::Identity;
use link::telemetry::StepReport;
use outerloop_core::{Design, Event, Fault, GroundMotion, Record, State, Trip};
use std::cell::RefCell;
use std::time::Instant;

/// Steps before arming: the loop averages where the specimen stands.
const IDLE_STEPS: u64 = 256;

/// A board at the other end of a connection.
pub struct BoardBench<P> {
    connection: RefCell<Connection<P>>,
}

impl<P: Port> BoardBench<P> {
    /// Over `connection`.
    pub fn new(connection: Connection<P>) -> Self {
        Self {
            connection: RefCell::new(connection),
        }
    }

    /// The connection back.
    pub fn into_connection(self) -> Connection<P> {
        self.connection.into_inner()
    }
}

impl<P: Port> Bench for BoardBench<P> {
    fn run<const N: usize>(
        &self,
        assignment: &Assignment<'_, N>,
        witness: &mut impl Witness,
    ) -> Result<Ending, Failure> {
        let board = &mut *self.connection.borrow_mut();
        let identity = identify(board)?;
        let points = points(assignment)?;
        prepare(board)?;
        let since = done(
            board,
            "configure",
            &Command::Configure(assignment.config.clone()),
        )?;
        load(board, points, assignment.interval_s)?;
        done(board, "signal", &Command::Signal(None))?;

        let step_s = assignment.config.model_step_s();
        let ground = GroundMotion::new(points, assignment.interval_s, step_s).ok_or_else(|| {
            Failure::input("the ground motion cannot be laid over the integration steps")
        })?;
        let substeps = u32::from(assignment.config.timing.substeps);
        let mut session = Session::<P, N>::new(
            board,
            &identity,
            assignment.design.clone(),
            substeps,
            ground,
            since,
        );
        session.wait_idle()?;
        session.send(Event::Arm)?;
        session.wait_for_start()?;
        let began = Instant::now();
        session.send(Event::Start)?;
        session.run(assignment.steps, witness, began, &identity)
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

/// Sends the ground motion.
fn load<P: Port>(
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
    fn new(
        board: &'b mut Connection<P>,
        identity: &Identity,
        design: Design<N>,
        substeps: u32,
        ground: GroundMotion<'a>,
        since: u32,
    ) -> Self {
        Self {
            lost_before: board.counted().1,
            board,
            mirror: Mirror::new(design, substeps, ground, identity.calibration, since),
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
    fn finish(&mut self) -> Result<(), Failure> {
        match self.send(Event::Finish) {
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

    fn run(
        mut self,
        steps: usize,
        witness: &mut impl Witness,
        began: Instant,
        identity: &Identity,
    ) -> Result<Ending, Failure> {
        let mut done = 0;
        let mut lost = None;
        let mut stopped = false;
        // Steps count by their number, not by their coming: some may be lost on the way.
        let mut first = None;
        let mut see = |record: Option<Record<N>>| {
            let running = |r: &Record<N>| r.mode().is_some_and(State::integrates);
            if let Some(record) = record.filter(running) {
                done = record.tick.wrapping_sub(*first.get_or_insert(record.tick)) as usize + 1;
                if done <= steps {
                    witness.see(&record);
                }
            }
            done
        };
        let ended = loop {
            match self.next() {
                Ok((tick, step)) => {
                    let done = see(self.mirror.take(tick, step));
                    // The record on the board is at most some steps longer than the test.
                    if done >= steps && self.state == State::Running && !stopped {
                        stopped = true;
                        self.finish()?;
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
        };
        see(self.mirror.last());
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
            clear(self.board)?;
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
            }),
        })
    }
}
