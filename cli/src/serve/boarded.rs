//! The rig behind a board, by the same way as a test on a ground motion: armed, asked for, mirrored, ended.

use super::mover::{Mover, Reached, Stop};
use super::rig::{Rig, Seen};
use super::travel::Travel;
use crate::bench::OnBoard;
use crate::board::limits::Plan;
use crate::board::operator::Operator;
use crate::board::{BoardConnection, InForce, Mirror, clear, done, ready, status};
use crate::failure::Failure;
use crate::files::test::{BoardWanted, TestFile};
use crate::scope::Scope;
use link::reply::Identity;
use link::telemetry::StepReport;
use link::{Calibration, Command};
use outerloop_core::{Config, Design, Event, Fault, GroundMotion, Mode, Pace, Record};
use std::collections::VecDeque;

/// The rig behind the board at the other end of `connection`. `real`: there is a person to look before a trip is cleared.
///
/// # Errors
/// A test with more storeys than the board has actuators, or one that moves continuously without a limit on its speed.
pub fn boarded(
    test: &TestFile,
    connection: BoardConnection,
    operator: Operator,
    real: bool,
    keep: bool,
    scope: Option<Scope>,
) -> Result<Box<dyn Mover>, Failure> {
    let storeys = test.config.degrees_of_freedom();
    if storeys != 1 {
        return Err(Failure::input(format!(
            "serve: the test has {storeys} storeys: accepted on a board is 1, the one with the actuator; the simulated rig serves all of them"
        )));
    }
    let limits = &test.config.limits;
    let has_speed = limits.velocity_m_per_s.is_some() || limits.increment_m.is_some();
    if test.serve.pace == Pace::Continuous && !has_speed {
        return Err(Failure::input(
            "serve: limits.velocity_m_per_s is missing beside serve.pace = \"continuous\": accepted on a board is the \
             largest speed, m/s, that the model may ask of the actuator",
        ));
    }
    let boarded = Boarded {
        board: connection,
        operator,
        real,
        plan: Plan::of_served(test),
        wanted: test.board.clone(),
        config: test.config.clone(),
        pace: test.serve.pace,
        test: None,
        permit: false,
        calibrated: None,
        account: None,
    };
    Ok(Box::new(Travel::<1, _>::new(boarded, test, keep, scope)))
}

/// A board with one actuator, all of the structure that is served.
struct Boarded {
    board: BoardConnection,
    operator: Operator,
    real: bool,
    plan: Plan,
    wanted: BoardWanted,
    config: Config,
    pace: Pace,
    /// From the beginning to the end.
    test: Option<Serving>,
    permit: bool,
    /// How the board's codes are to be read, once it has been asked.
    calibrated: Option<Calibration>,
    account: Option<OnBoard>,
}

/// A client's test on the board.
struct Serving {
    in_force: InForce<'static, 1>,
    identity: Identity,
    /// Records that have come and that nobody has seen yet.
    come: VecDeque<Record<1>>,
    /// The board's button holds it, and the person has been asked.
    held: bool,
    lost: Option<String>,
    trip: Option<Fault>,
}

impl Boarded {
    /// What to do with the test, where there is one; a link that is gone is remembered.
    fn with<T>(
        &mut self,
        act: impl FnOnce(&mut BoardConnection, &mut Serving) -> Result<T, Failure>,
    ) -> Result<T, Stop> {
        let Some(test) = &mut self.test else {
            return Err(Stop::Lost("no test is in force on the board".into()));
        };
        act(&mut self.board, test).map_err(|e| {
            test.lost = Some(e.to_string());
            Stop::Lost(e.to_string())
        })
    }

    /// Takes in what has come; after the last step of a test that tripped, that step, too.
    fn listen(&mut self) -> Result<(), Stop> {
        self.with(|board, test| {
            let come = test.in_force.come(board)?;
            test.come.extend(come);
            if test.in_force.state() == Mode::Tripped {
                test.come.extend(test.in_force.last());
            }
            Ok(())
        })
    }

    /// The next step that has come and that nobody has seen, and, behind the last one, why the board goes no further.
    fn next_seen(&mut self) -> Result<Option<Seen<1>>, Stop> {
        self.with(|board, test| {
            let Some(record) = test.come.pop_front() else {
                return Ok(None);
            };
            let over = test.come.is_empty() && test.in_force.state() == Mode::Tripped;
            let trip = if over { status(board)?.trip } else { None };
            test.trip = test.trip.or(trip.map(|t| t.fault));
            Ok(Some(Seen {
                reached: Reached {
                    displacement_m: record.estimated_displacement_m.map(f64::from).to_vec(),
                    force_n: record.estimated_force_n.map(f64::from).to_vec(),
                },
                record,
                ended: trip.map(Stop::Tripped),
            }))
        })
    }

    /// A step between two clients, as the board reports it.
    fn idle(&self, (tick, step): (u32, StepReport)) -> Option<Seen<1>> {
        let calibration = self.calibrated?;
        let mut record = Record::<1>::EMPTY;
        (record.tick, record.flags) = (tick, step.flags);
        (record.command_m, record.sent_m) = ([step.command_m], [step.command_m]);
        record.displacement_m = [calibration.displacement.quantity(step.displacement)];
        record.force_n = [calibration.force.quantity(step.force)];
        Some(Seen {
            record,
            reached: Reached::default(),
            ended: None,
        })
    }

    /// The board's own button has held the test: the person goes on.
    fn go_on(&mut self) -> Result<(), Stop> {
        let Some(test) = &mut self.test else {
            return Ok(());
        };
        let holds = test.in_force.state() == Mode::Holding;
        if holds && !std::mem::replace(&mut test.held, holds) {
            self.operator
                .ask("the test is held: Enter goes on, Ctrl-C stops");
        }
        test.held = holds;
        if holds && self.operator.is_asked() && self.operator.agrees() {
            self.with(|board, test| test.in_force.send(board, Event::Start))?;
        }
        Ok(())
    }
}

impl Rig<1> for Boarded {
    fn begin(&mut self) -> Result<(), Failure> {
        let board = &mut self.board;
        (self.test, self.account) = (None, None);
        let wanted = (
            self.wanted.calibration.as_deref(),
            self.wanted.converter_bits,
        );
        let (identity, config) = ready(board, &self.config, &self.plan, wanted)?;
        let design = Design::<1>::new(&config).map_err(|e| Failure::input(e.to_string()))?;
        let since = done(board, "configure", &Command::Configure(config.clone()))?;
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
        let mut in_force = InForce::new(board, mirror, since, &identity);
        in_force.arm(board)?;
        in_force.wait_for_go(board, &self.operator)?;
        self.permit = true;
        self.calibrated = Some(identity.calibration);
        self.test = Some(Serving {
            in_force,
            identity,
            come: VecDeque::new(),
            held: false,
            lost: None,
            trip: None,
        });
        Ok(())
    }

    fn aim(&mut self, [target_m]: [f32; 1]) -> Result<(), Stop> {
        self.with(|board, test| {
            // The answer says what has become of it; a board that has tripped since takes it, and goes nowhere.
            test.in_force.aim(board, target_m)?;
            if test.in_force.state() == Mode::Armed {
                test.in_force.send(board, Event::Start)?;
            }
            Ok(())
        })
    }

    fn step(&mut self) -> Result<Seen<1>, Stop> {
        loop {
            self.go_on()?;
            if let Some(seen) = self.next_seen()? {
                return Ok(seen);
            }
            self.listen()?;
        }
    }

    fn meanwhile(&mut self) -> Result<Vec<Seen<1>>, Stop> {
        if self.test.is_none() {
            // Between two clients the board hears that the PC is there.
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

    fn wish(&mut self, wish: Event) -> Result<(), Stop> {
        if self.test.is_some() {
            return self.with(|board, test| test.in_force.ask_for(board, wish));
        }
        // Between two clients there is nothing but a trip to be cleared.
        match wish {
            Event::Clear => clear(&mut self.board).map_err(|e| Stop::Lost(e.to_string())),
            _ => Ok(()),
        }
    }

    fn answer_n(&self) -> Result<[f32; 1], Stop> {
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
            // Nothing was begun, or not to its end.
            return self.stand_down();
        };
        let ended = match &test.lost {
            // The board gives up a PC that it does not hear: PERMIT is low half a second later.
            Some(why) => Err(Failure::test(why.clone())),
            None => self.finish(&mut test),
        };
        let vitals = ended
            .as_ref()
            .ok()
            .and_then(|()| status(&mut self.board).ok());
        self.permit = vitals.as_ref().is_some_and(|v| v.permit);
        let why = ended.as_ref().err().map(Failure::to_string);
        self.account = Some(test.in_force.account(
            &self.board,
            &test.identity,
            vitals.as_ref(),
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

impl Boarded {
    /// To a standstill on the ramp, then idle.
    fn finish(&mut self, test: &mut Serving) -> Result<(), Failure> {
        let (board, in_force) = (&mut self.board, &mut test.in_force);
        if !over(status(board)?.state) {
            in_force.end(board, Event::Stop)?;
        }
        while !over(in_force.state()) {
            in_force.next(board)?;
        }
        in_force.wait_for_rest(board)?;
        self.stand_down()
    }

    /// Idle, whatever it was doing; a trip is left as it is where a person has to look first.
    fn stand_down(&mut self) -> Result<(), Failure> {
        loop {
            let now = status(&mut self.board)?;
            self.permit = now.permit;
            match now.state {
                Mode::Idle => return Ok(()),
                Mode::Tripped if self.real => return Ok(()),
                Mode::Finished | Mode::Tripped => clear(&mut self.board)?,
                _ => drop(done(&mut self.board, "stop", &Command::Event(Event::Stop))?),
            }
        }
    }
}

/// Nothing moves any more, or is about to come to rest.
fn over(state: Mode) -> bool {
    matches!(state, Mode::Idle | Mode::Finished | Mode::Tripped)
}
