//! The rig behind a board, run as in a test on a ground motion: armed, recomputed on the PC, ended.

use super::mover::{Mover, Stop, TargetMeasurement};
use super::served_rig::{ServedRig, ServedStep};
use super::travel::Travel;
use crate::board::limits::PlannedMotion;
use crate::board::operator::Operator;
use crate::board::{
    BoardConnection, ConfiguredTest, DIFFERS, Hold, Mirror, clear, coupled_test, done, ready,
    status,
};
use crate::scope::Scope;
use experiment::bench::OnBoard;
use experiment::failure::Failure;
use experiment::files::test::{BoardWanted, TestFile};
use link::command::BoardTest;
use link::reply::Identity;
use link::telemetry::StepReport;
use link::{Calibration, Command, MAX_ACTUATORS};
use outerloop_core::coupled::CoupledRig;
use outerloop_core::{
    Config, Design, DirectRig, Event, Fault, GroundMotion, Mode, Pace, Record, Rig,
};
use std::collections::VecDeque;

/// The rig behind the board at the other end of `connection`. `real`: a person must look before a trip is cleared.
///
/// # Errors
/// A test with more storeys than any board has actuators, or one that moves continuously without a velocity limit.
pub fn serve_on_board(
    test: &TestFile,
    connection: BoardConnection,
    operator: Operator,
    real: bool,
    keep: bool,
    scope: Option<Scope>,
) -> Result<Box<dyn Mover>, Failure> {
    let storeys = test.config.degrees_of_freedom();
    let limits = &test.config.limits;
    let has_speed = limits.velocity_m_per_s.is_some() || limits.increment_m.is_some();
    if test.serve.pace == Pace::Continuous && !has_speed {
        return Err(Failure::input(
            "serve: limits.velocity_m_per_s is missing beside serve.pace = \"continuous\": accepted on a board is the \
             largest speed, m/s, that the model may ask of the actuator",
        ));
    }
    let with = (connection, operator, real);
    let kept = (keep, scope);
    if let Some(part) = &test.coupled {
        let part = part.clone();
        let prepare: Prepare<2, CoupledRig> = Box::new(move |config| coupled_test(&part, config));
        return Ok(moved(test, with, (Hold::Coupler, prepare), kept));
    }
    Ok(match storeys {
        1 => moved(test, with, (Hold::Storeys, Box::new(of_storeys::<1>)), kept),
        2 => moved(test, with, (Hold::Storeys, Box::new(of_storeys::<2>)), kept),
        3 => moved(test, with, (Hold::Storeys, Box::new(of_storeys::<3>)), kept),
        _ => {
            return Err(Failure::input(format!(
                "serve: the test has {storeys} storeys: accepted on a board are up to {MAX_ACTUATORS}, each with an actuator; the simulated rig serves any number"
            )));
        }
    })
}

/// From a configuration with all required limits: the test as sent to the board, and the loop that the board then runs.
type Prepare<const N: usize, R> = Box<dyn Fn(Config) -> Result<(BoardTest, Design<N, R>), Failure>>;

/// For a frame whose storeys each have an actuator.
fn of_storeys<const N: usize>(
    config: Config,
) -> Result<(BoardTest, Design<N, DirectRig<N>>), Failure> {
    let design = Design::new(&config).map_err(Failure::input)?;
    Ok((config.into(), design))
}

fn moved<const N: usize, R: Rig<N> + 'static>(
    test: &TestFile,
    with: (BoardConnection, Operator, bool),
    held: (Hold, Prepare<N, R>),
    (keep, scope): (bool, Option<Scope>),
) -> Box<dyn Mover> {
    let rig = BoardRig::new(test, with, held);
    Box::new(Travel::new(rig, test, keep, scope))
}

/// A board whose actuators hold all of the served structure: one storey each, or two of them a coupler.
struct BoardRig<const N: usize, R: Rig<N>> {
    board: BoardConnection,
    operator: Operator,
    real: bool,
    plan: PlannedMotion,
    wanted: BoardWanted,
    config: Config,
    hold: Hold,
    prepare: Prepare<N, R>,
    pace: Pace,
    /// Set from the beginning of a client's test to its end.
    test: Option<Serving<N, R>>,
    permit: bool,
    /// The calibration of each actuator, once the board has been asked.
    calibrated: Vec<Calibration>,
    account: Option<OnBoard>,
}

/// A client's test on the board.
struct Serving<const N: usize, R: Rig<N>> {
    in_force: ConfiguredTest<'static, N, R>,
    identity: Identity,
    /// Records that were received but not passed on yet.
    come: VecDeque<Record<N>>,
    lost: Option<String>,
    trip: Option<Fault>,
}

impl<const N: usize, R: Rig<N>> BoardRig<N, R> {
    fn new(
        test: &TestFile,
        (board, operator, real): (BoardConnection, Operator, bool),
        (hold, prepare): (Hold, Prepare<N, R>),
    ) -> Self {
        Self {
            board,
            operator,
            real,
            plan: PlannedMotion::of_served(test),
            wanted: test.board.clone(),
            config: test.config.clone(),
            hold,
            prepare,
            pace: test.serve.pace,
            test: None,
            permit: false,
            calibrated: Vec::new(),
            account: None,
        }
    }

    /// Acts on the test in force; a lost link is remembered.
    fn with<T>(
        &mut self,
        act: impl FnOnce(&mut BoardConnection, &mut Serving<N, R>) -> Result<T, Failure>,
    ) -> Result<T, Stop> {
        let Some(test) = &mut self.test else {
            return Err(Stop::Lost("no test is in force on the board".into()));
        };
        act(&mut self.board, test).map_err(|e| {
            test.lost = Some(e.to_string());
            Stop::Lost(e.to_string())
        })
    }

    /// Receives what has come; once a test has tripped, also its last step.
    fn listen(&mut self) -> Result<(), Stop> {
        self.with(|board, test| {
            let come = test.in_force.come(board)?;
            test.come.extend(come);
            if test.in_force.mode() == Mode::Tripped {
                test.come.extend(test.in_force.last());
            }
            Ok(())
        })
    }

    /// The next unseen step; with the last one, the trip that ended the test.
    fn next_seen(&mut self) -> Result<Option<ServedStep<N>>, Stop> {
        self.with(|board, test| {
            let Some(record) = test.come.pop_front() else {
                return Ok(None);
            };
            if test.in_force.mirror().differs() {
                return Err(Failure::test(DIFFERS));
            }
            // The telemetry of such a step has readings of the actuators, which are not x and rotation.
            if !R::SAME_COORDINATES && !test.in_force.mirror().is_in_step() {
                return Err(Failure::test(
                    "a step was lost between the board and the PC, and with it where x and the rotation are",
                ));
            }
            let over = test.come.is_empty() && test.in_force.mode() == Mode::Tripped;
            let trip = if over { status(board)?.trip } else { None };
            test.trip = test.trip.or(trip.map(|t| t.fault));
            Ok(Some(ServedStep {
                reached: TargetMeasurement::estimated(&record),
                coupled: None,
                record,
                ended: trip.map(Stop::Tripped),
            }))
        })
    }

    /// A step between two clients, as the board reports it.
    fn idle(&self, (tick, step): (u32, StepReport)) -> Option<ServedStep<N>> {
        if self.calibrated.is_empty() {
            return None;
        }
        let mut record = Record::<N>::EMPTY;
        (record.tick, record.flags) = (tick, step.flags);
        (record.command_m[0], record.sent_m[0]) = (step.command_m, step.command_m);
        for (actuator, lines) in self.calibrated.iter().enumerate().take(N) {
            let codes = step.codes(actuator).unwrap_or_default();
            [record.displacement_m[actuator], record.force_n[actuator]] = lines.readings(codes);
        }
        Some(ServedStep {
            record,
            reached: TargetMeasurement::default(),
            coupled: None,
            ended: None,
        })
    }

    /// The board's own button has held the test: the person resumes it.
    fn go_on(&mut self) -> Result<(), Stop> {
        let Self {
            board,
            operator,
            test: Some(test),
            ..
        } = self
        else {
            return Ok(());
        };
        let went_on = match test.in_force.is_to_go_on(operator) {
            Ok(true) => test.in_force.go_on(board, operator),
            waits => waits.map(drop),
        };
        went_on.map_err(|e| {
            test.lost = Some(e.to_string());
            Stop::Lost(e.to_string())
        })
    }
}

impl<const N: usize, R: Rig<N>> ServedRig<N> for BoardRig<N, R> {
    fn begin(&mut self) -> Result<(), Failure> {
        let board = &mut self.board;
        (self.test, self.account) = (None, None);
        let wanted = (
            self.wanted.calibration.as_deref(),
            self.wanted.converter_bits,
        );
        let (identity, config) = ready(board, (&self.config, self.hold), &self.plan, wanted)?;
        let (sent, design) = (self.prepare)(config.clone())?;
        let since = done(board, "configure", &Command::Configure(sent))?;
        done(board, "signal", &Command::Signal(None))?;
        done(board, "pace", &Command::Pace(Some(self.pace)))?;
        let mut mirror = Mirror::new(
            design,
            u32::from(config.timing.substeps),
            GroundMotion::none(),
            &identity,
            since,
        );
        mirror.take_targets(self.pace);
        let mut in_force = ConfiguredTest::new(board, mirror, since, &identity);
        in_force.arm(board, &identity, &self.operator, &config)?;
        in_force.wait_for_go(board, &self.operator)?;
        self.permit = true;
        self.calibrated = identity.calibrations().copied().collect();
        self.test = Some(Serving {
            in_force,
            identity,
            come: VecDeque::new(),
            lost: None,
            trip: None,
        });
        Ok(())
    }

    fn aim(&mut self, target_m: [f32; N]) -> Result<(), Stop> {
        self.with(|board, test| {
            // The reply says what became of it; a board that has tripped meanwhile accepts it and does not move.
            test.in_force.aim(board, target_m)?;
            match test.in_force.mode() {
                Mode::Armed => test.in_force.start(board),
                Mode::Idle => Err(Failure::test(
                    "the test was ended before its first target by the board's button, and the board is idle",
                )),
                _ => Ok(()),
            }
        })
    }

    fn step(&mut self) -> Result<ServedStep<N>, Stop> {
        loop {
            self.go_on()?;
            if let Some(seen) = self.next_seen()? {
                return Ok(seen);
            }
            self.listen()?;
        }
    }

    fn meanwhile(&mut self) -> Result<Vec<ServedStep<N>>, Stop> {
        if self.test.is_none() {
            // Between two clients the board also needs heartbeats from the PC.
            let steps = self.board.steps().map_err(|e| Stop::Lost(e.to_string()))?;
            return Ok(steps.into_iter().filter_map(|s| self.idle(s)).collect());
        }
        self.go_on()?;
        self.listen()?;
        let mut seen = Vec::new();
        while let Some(next) = self.next_seen()? {
            seen.push(next);
        }
        Ok(seen)
    }

    fn has_own_time(&self) -> bool {
        true
    }

    fn request(&mut self, event: Event) -> Result<(), Stop> {
        if self.test.is_some() {
            return self.with(|board, test| test.in_force.ask_for(board, event));
        }
        // Between two clients only a trip can be cleared.
        match event {
            Event::Clear => clear(&mut self.board).map_err(|e| Stop::Lost(e.to_string())),
            _ => Ok(()),
        }
    }

    fn answer_n(&self) -> Result<[f32; N], Stop> {
        let answer = self
            .test
            .as_ref()
            .and_then(|t| t.in_force.mirror().answer_n());
        answer.copied().ok_or_else(|| {
            Stop::Lost(
                "a step was lost between the board and the PC, and with it the force that the compensation answers with"
                    .into(),
            )
        })
    }

    fn end(&mut self) -> Result<(), Failure> {
        let Some(mut test) = self.test.take() else {
            // Nothing was begun, or the beginning failed.
            return self.bring_to_idle();
        };
        // Done also with a lost link: the board may still hear the PC. A board that does not hear it gives the PC up after
        // 0.5 s, and drops PERMIT at the end of its ramp.
        let finished = self.finish(&mut test);
        let board_status = match &finished {
            Ok(()) => status(&mut self.board).ok(),
            Err(_) => None,
        };
        let ended = match test.lost.take() {
            Some(why) => Err(Failure::test(why)),
            None => finished,
        };
        // A board that does not answer counts as one with PERMIT.
        self.permit = board_status.as_ref().is_none_or(|v| v.permit);
        let why = ended.as_ref().err().map(Failure::to_string);
        self.account = Some(test.in_force.account(
            &self.board,
            &test.identity,
            board_status.as_ref(),
            why,
            test.trip,
        ));
        ended
    }

    fn permit(&self) -> bool {
        self.permit
    }

    fn on_board(&self) -> Option<OnBoard> {
        self.account.clone()
    }
}

impl<const N: usize, R: Rig<N>> BoardRig<N, R> {
    /// Brings the rig to rest on the deceleration ramp, then makes the board idle.
    fn finish(&mut self, test: &mut Serving<N, R>) -> Result<(), Failure> {
        let (board, in_force) = (&mut self.board, &mut test.in_force);
        if !has_ended(status(board)?.mode) {
            in_force.end(board, Event::Stop)?;
        }
        while !has_ended(in_force.mode()) {
            in_force.next(board)?;
        }
        in_force.come_to_rest(board)?;
        self.bring_to_idle()
    }

    /// Makes the board idle from any mode; a trip is left if a person has to look first.
    fn bring_to_idle(&mut self) -> Result<(), Failure> {
        loop {
            let now = status(&mut self.board)?;
            self.permit = now.permit;
            match now.mode {
                Mode::Idle => return Ok(()),
                Mode::Tripped if self.real => return Ok(()),
                Mode::Finished | Mode::Tripped => clear(&mut self.board)?,
                // It comes to rest by itself.
                Mode::Stopping => {}
                _ => drop(done(&mut self.board, "stop", &Command::Event(Event::Stop))?),
            }
        }
    }
}

/// True if nothing moves any more, or the last ramp runs.
fn has_ended(mode: Mode) -> bool {
    matches!(mode, Mode::Idle | Mode::Finished | Mode::Tripped)
}
