//! A whole test on a board.

use super::commission::commission;
use super::configured_test::ConfiguredTest;
use super::connection::Connection;
use super::limits::PlannedMotion;
use super::mirror::{DIFFERS, Mirror};
use super::operator::Operator;
use super::orders::{done, event, status};
use super::port::Port;
use super::setup::{Hold, ready};
use super::trajectory::Trajectory;
use super::upload::load;
use crate::terminal::interrupt;
use experiment::bench::Played;
use experiment::bench::interface::{Bench, Ending, PreparedTest};
use experiment::coupled::part::CoupledPart;
use experiment::coupled::settings;
use experiment::failure::Failure;
use experiment::files::test::TestFile;
use experiment::trace::TestObserver;
use link::Command;
use link::command::{BoardTest, MAX_POINTS};
use link::reply::Identity;
use outerloop_core::coupled::CoupledRig;
use outerloop_core::{Config, Design, Event, Fault, GroundMotion, Mode, Record, Rig, Trip};
use std::cell::RefCell;
use std::time::Instant;

/// A board at the other end of a connection.
pub struct BoardBench<P> {
    connection: RefCell<Connection<P>>,
    plan: PlannedMotion,
    operator: Operator,
    /// The number that the board's calibration must have.
    calibration: Option<String>,
    /// The resolution that its converters must have, bits.
    bits: Option<u16>,
}

impl<P: Port> BoardBench<P> {
    /// Over `connection`, for tests whose motion is `plan`; `operator` is asked before each start.
    pub fn new(connection: Connection<P>, plan: PlannedMotion, operator: Operator) -> Self {
        Self {
            connection: RefCell::new(connection),
            plan,
            operator,
            calibration: None,
            bits: None,
        }
    }

    /// Accepts only a board whose calibration has this number, eight hexadecimal digits.
    pub fn expecting(mut self, calibration: Option<String>) -> Self {
        self.calibration = calibration;
        self
    }

    /// Accepts only a board whose converters have this resolution.
    pub fn with_bits(mut self, bits: Option<u16>) -> Self {
        self.bits = bits;
        self
    }

    /// Moves the first actuator by `trajectory` on the same board; see [`commission`].
    ///
    /// # Errors
    /// Those of [`commission`].
    pub fn play(
        &self,
        test: &TestFile,
        trajectory: &Trajectory,
        observer: &mut dyn TestObserver,
    ) -> Result<Played, Failure> {
        let board = &mut *self.connection.borrow_mut();
        commission(board, test, (trajectory, 0), &self.operator, observer)
    }

    /// Gives the connection back.
    pub fn into_connection(self) -> Connection<P> {
        self.connection.into_inner()
    }
}

impl<P: Port> Bench for BoardBench<P> {
    fn run<const N: usize>(
        &self,
        test: &PreparedTest<'_, N>,
        observer: &mut dyn TestObserver,
    ) -> Result<Ending, Failure> {
        let (identity, config) = self.ready((test.config, Hold::Storeys))?;
        let design = Design::new(&config).map_err(Failure::input)?;
        let (ending, _) = self.run_as(test, &identity, (config.into(), design), observer)?;
        Ok(ending)
    }

    fn run_coupled<const N: usize>(
        &self,
        part: &CoupledPart,
        test: &PreparedTest<'_, N, CoupledRig>,
        observer: &mut dyn TestObserver,
    ) -> Result<Ending, Failure> {
        only_x_and_rotation(part)?;
        let (identity, config) = self.ready((test.config, Hold::Coupler))?;
        let sent_and_design = coupled_test(part, config)?;
        let (ending, rig) = self.run_as(test, &identity, sent_and_design, observer)?;
        Ok(Ending {
            actuators: rig.map(|rig| *rig.plant()),
            ..ending
        })
    }
}

/// Checks that a test of two coupled actuators has no further coordinates.
///
/// # Errors
/// It has some.
pub(super) fn only_x_and_rotation(part: &CoupledPart) -> Result<(), Failure> {
    match part.coordinates() {
        2 => Ok(()),
        more => Err(Failure::input(format!(
            "coupled.structure.coordinates has {more} names: accepted on a board are 2, x and the rotation; the simulated rig runs up to 8"
        ))),
    }
}

/// A test of two coupled actuators as sent to a board, and the loop that the board then runs. `config` has all limits
/// that a board requires.
///
/// # Errors
/// The first value that core refuses.
pub(crate) fn coupled_test<const N: usize>(
    part: &CoupledPart,
    config: Config,
) -> Result<(BoardTest, Design<N, CoupledRig>), Failure> {
    let kind = part.declared.compensation;
    let design = settings::design::<N>(&part.declared, &config, kind)?;
    // The same design with the number of coordinates that the link supports.
    let coupled = Some(settings::of::<2>(&part.declared, &config, kind)?);
    Ok((BoardTest { config, coupled }, design))
}

impl<P: Port> BoardBench<P> {
    /// Makes the board idle; gives its identity and the configuration with all required limits.
    fn ready(&self, test: (&Config, Hold)) -> Result<(Identity, Config), Failure> {
        let wanted = (self.calibration.as_deref(), self.bits);
        ready(&mut *self.connection.borrow_mut(), test, &self.plan, wanted)
    }

    /// Runs a test with the loop `design`, sent to the board as `sent`. Also gives the rig as that loop has it at the
    /// end, if every step is known.
    fn run_as<const N: usize, R: Rig<N>>(
        &self,
        test: &PreparedTest<'_, N, R>,
        identity: &Identity,
        (sent, design): (BoardTest, Design<N, R>),
        observer: &mut dyn TestObserver,
    ) -> Result<(Ending, Option<R>), Failure> {
        let points = points(test)?;
        let board = &mut *self.connection.borrow_mut();
        let config = sent.config.clone();
        let since = done(board, "configure", &Command::Configure(sent))?;
        load(board, points, test.interval_s)?;
        done(board, "signal", &Command::Signal(None))?;

        let step_s = config.model_step_s();
        let ground = GroundMotion::new(points, test.interval_s, step_s).ok_or_else(|| {
            Failure::input("the ground motion cannot be laid over the integration steps")
        })?;
        let mirror = Mirror::new(
            design,
            u32::from(config.timing.substeps),
            ground,
            identity,
            since,
        );
        interrupt::watch_rig();
        let mut in_force = ConfiguredTest::<N, R>::new(board, mirror, since, identity);
        if let Some(told) = observer.watches_the_loop() {
            in_force.watch(board, told)?;
        }
        in_force.arm(board, identity, &self.operator, &config)?;
        in_force.wait_for_go(board, &self.operator)?;
        let began = Instant::now();
        in_force.start(board)?;
        let running = Test {
            board,
            in_force,
            identity,
            operator: &self.operator,
            wanted: test.steps,
            steps: Steps::default(),
            told: None,
        };
        running.run(observer, began)
    }
}

/// The points of the ground motion that the test needs.
fn points<'a, const N: usize, R: Rig<N>>(
    test: &PreparedTest<'a, N, R>,
) -> Result<&'a [f32], Failure> {
    let config = test.config;
    let seconds = test.steps as f64 / config.timing.rate_hz / config.timing.time_scale;
    let needed = (seconds / test.interval_s).ceil() as usize + 2;
    let all = test.points_m_per_s2;
    let points = all.get(..needed).unwrap_or(all);
    if points.len() > MAX_POINTS {
        return Err(Failure::input(format!(
            "the ground motion has {} points in {seconds} s: accepted on a board are up to {MAX_POINTS}; a --duration, or fewer points a second",
            points.len()
        )));
    }
    Ok(points)
}

/// Why a test was told to end.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Told {
    /// Its steps are done.
    Done,
    /// A person wanted it.
    ByHand,
    /// The board's bits differ from the PC's.
    Differs,
}

/// The steps of a running test. They are counted by their numbers, since some may be lost on the link. Steps of a hold do
/// not count.
#[derive(Default)]
struct Steps {
    done: usize,
    first: Option<u32>,
    last_running: u32,
    in_hold: u32,
}

impl Steps {
    /// True if the record is of a step of the running test.
    fn count<const N: usize>(&mut self, record: &Record<N>) -> bool {
        let mode = record.mode();
        if matches!(mode, Some(Mode::Holding | Mode::Returning)) {
            self.in_hold = record.tick.wrapping_sub(self.last_running);
        }
        let running = mode.is_some_and(Mode::integrates);
        if running {
            let first = self.first.get_or_insert(record.tick);
            *first = first.wrapping_add(std::mem::take(&mut self.in_hold));
            self.last_running = record.tick;
            self.done = record.tick.wrapping_sub(*first) as usize + 1;
        }
        running
    }
}

/// A test that has been started.
struct Test<'a, 'b, P, const N: usize, R: Rig<N>> {
    board: &'b mut Connection<P>,
    in_force: ConfiguredTest<'a, N, R>,
    identity: &'b Identity,
    operator: &'b Operator,
    /// Control steps of the whole test.
    wanted: usize,
    steps: Steps,
    /// Why it was told to end, once it was.
    told: Option<Told>,
}

impl<P: Port, const N: usize, R: Rig<N>> Test<'_, '_, P, N, R> {
    fn run(
        mut self,
        observer: &mut dyn TestObserver,
        began: Instant,
    ) -> Result<(Ending, Option<R>), Failure> {
        let (ended, lost) = loop {
            match self.go_on(observer) {
                Ok(None) => {}
                Ok(Some(ended)) => break (ended, None),
                Err(failure) => {
                    // What was received is kept. The board may still hear the PC even if the PC does not hear the board.
                    if event(self.board, Event::Stop).is_ok() {
                        let _ = self.in_force.until_still(self.board);
                    }
                    break (Mode::Tripped, Some(failure.to_string()));
                }
            }
        };
        let last = self.in_force.last();
        self.observe(last, observer);
        let rig = self.in_force.mirror().rig().cloned();
        let ending = self.ending(ended, lost, began.elapsed().as_secs_f64());
        Ok((ending, rig))
    }

    /// One step, and what somebody requested in it; gives the mode in which the board ended, if it has.
    fn go_on(&mut self, observer: &mut dyn TestObserver) -> Result<Option<Mode>, Failure> {
        // Read before the observer is called, so that it sees as much: its requests are kept for a replay.
        let interrupted = interrupt::asked();
        let before = self.in_force.steps();
        let record = self.in_force.next(self.board)?;
        self.observe(record, observer);
        // An observer counts steps by how often it is called.
        if self.in_force.steps() > before {
            self.do_as_asked(observer)?;
        }
        // The board's record is at most a few steps longer than the test.
        if self.steps.done >= self.wanted && self.in_force.mode().integrates() {
            self.end(Told::Done)?;
        }
        let mode = self.in_force.mode();
        if matches!(mode, Mode::Finished | Mode::Tripped) {
            return Ok(Some(mode));
        }
        if interrupted {
            self.end(Told::ByHand)?;
        }
        // A bit of the test that the board stores has turned over: the limits still allow much motion that is not the
        // test.
        if self.in_force.mirror().differs() && !self.is_ending() && mode.integrates() {
            self.end(Told::Differs)?;
        }
        if !self.is_ending() {
            self.hold_or_go_on()?;
        }
        Ok(None)
    }

    /// Carries out what an observer requests after a step.
    fn do_as_asked(&mut self, observer: &mut dyn TestObserver) -> Result<(), Failure> {
        let asked = observer.requested_event();
        // Before the next step, in which the request may have to take effect.
        self.in_force.be_judged(observer);
        match asked {
            Some(Event::Stop) => self.end(Told::ByHand),
            Some(asked) if !self.is_ending() => self.in_force.ask_for(self.board, asked),
            _ => Ok(()),
        }
    }

    /// Shows the observer a record, if one came.
    fn observe(&mut self, record: Option<Record<N>>, observer: &mut dyn TestObserver) {
        let Some(record) = record else {
            return;
        };
        if !self.steps.count(&record) {
            observer.on_idle_step(&(&record).into());
        } else if self.steps.done <= self.wanted {
            observer.on_step(&(&record).into());
        }
    }

    fn is_ending(&self) -> bool {
        self.told.is_some()
    }

    /// Tells the board to end the test, once.
    fn end(&mut self, why: Told) -> Result<(), Failure> {
        if self.is_ending() {
            return Ok(());
        }
        self.told = Some(why);
        let how = if why == Told::Done {
            Event::Finish
        } else {
            Event::Stop
        };
        self.in_force.end(self.board, how)
    }

    /// Reports once that the board's button holds the test, and resumes it when somebody agrees.
    fn hold_or_go_on(&mut self) -> Result<(), Failure> {
        match self.in_force.is_to_go_on(self.operator) {
            Ok(true) => self.in_force.go_on(self.board, self.operator)?,
            Ok(false) => {}
            Err(gone) => {
                eprintln!("outerloop: {gone}");
                self.end(Told::ByHand)?;
            }
        }
        Ok(())
    }

    /// The account of a test that has ended. `lost`: why the board's state is no longer known. A board that cannot be
    /// read is reported, and the part of the test that was seen is kept.
    fn ending(mut self, mut ended: Mode, mut lost: Option<String>, wall_s: f64) -> Ending {
        let mut board_status = None;
        if lost.is_none() {
            match status(self.board) {
                Ok(status) => board_status = Some(status),
                Err(failure) => lost = Some(failure.to_string()),
            }
        }
        if ended == Mode::Finished && lost.is_none() {
            match self.in_force.come_to_rest(self.board) {
                // A trip on the deceleration ramp.
                Ok(()) if self.in_force.mode() == Mode::Tripped => {
                    ended = Mode::Tripped;
                    board_status = status(self.board).ok().or(board_status);
                }
                Ok(()) => {}
                Err(failure) => lost = Some(failure.to_string()),
            }
        }
        let of_board = board_status.as_ref().and_then(|status| status.trip);
        let seen = || Trip {
            fault: self.in_force.fault().unwrap_or(Fault::LinkLost),
            axis: 0,
            value: f32::NAN,
            limit: f32::NAN,
            tick: 0,
        };
        let trip = (ended == Mode::Tripped).then(|| of_board.unwrap_or_else(seen));
        let told = self.told;
        let lost = lost.or_else(|| (told == Some(Told::Differs)).then(|| DIFFERS.to_owned()));
        let (board, board_status) = (&*self.board, board_status.as_ref());
        let fault = trip.map(|t| t.fault);
        Ending {
            mode: ended,
            trip,
            by_hand: told.is_some_and(|why| why != Told::Done) && self.steps.done < self.wanted,
            wall_s,
            board: Some(
                self.in_force
                    .account(board, self.identity, board_status, lost, fault),
            ),
            actuators: None,
        }
    }
}
