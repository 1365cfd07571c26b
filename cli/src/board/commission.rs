//! A commissioning signal on a board: the command, the displacement, the force.

use super::connection::Connection;
use super::cross_readings::CrossReadings;
use super::limits::PlannedMotion;
use super::operator::Operator;
use super::orders::{clear, done, event, started_again, status};
use super::port::Port;
use super::setup::{Hold, ready};
use super::standing::Standing;
use super::trajectory::Trajectory;
use crate::terminal::interrupt;
use experiment::bench::{IDLE_STEPS, Played};
use experiment::failure::Failure;
use experiment::files::test::TestFile;
use experiment::trace::TestObserver;
use link::continuity::Ticks;
use link::limits::CalibratedRange;
use link::reply::Identity;
use link::telemetry::StepReport;
use link::{Command, MAX_ACTUATORS};
use outerloop_core::{Config, Event, Fault, Mode, Record, Trip};

/// Steps for which the command must stand still after the end.
const REST_STEPS: u32 = 40;

/// Steps by which a signal may be shorter than planned, from the start command to its end.
const SHORT_STEPS: usize = 4;

fn given_up() -> Failure {
    Failure::test("the signal was given up before anything moved")
}

/// Moves an actuator, numbered from 0, by a trajectory under the limits of `test`, or those that follow from the
/// trajectory. The board's other actuators stand at zero, under the same limits.
///
/// # Errors
/// A trajectory beyond a limit of the test; a board that is refused, not idle, not the one that the test names, or
/// without such an actuator; a signal that is refused; a link that is lost before the start.
pub fn commission<P: Port>(
    board: &mut Connection<P>,
    test: &TestFile,
    (trajectory, actuator): (&Trajectory, usize),
    operator: &Operator,
    observer: &mut dyn TestObserver,
) -> Result<Played, Failure> {
    trajectory.check(&test.config)?;
    let storeys = test
        .config
        .physical_storeys()
        .min(test.config.degrees_of_freedom());
    if actuator >= storeys {
        return Err(Failure::input(format!(
            "--actuator {}: the test has {storeys} storeys in the laboratory, each with an actuator: accepted are 1 to {storeys}",
            actuator + 1
        )));
    }
    let plan = PlannedMotion::of_trajectory(test, trajectory, actuator);
    let wanted = (test.board.calibration.as_deref(), test.board.converter_bits);
    // A signal needs no force, and may move by less than this limit of a test.
    let mut config = test.config.clone();
    config.limits.force_stands_m = None;
    let (identity, config) = ready(board, (&config, Hold::Storeys), &plan, wanted)?;
    done(
        board,
        "configure",
        &Command::Configure(config.clone().into()),
    )?;
    trajectory.send(board, &config, actuator as u8)?;
    let shown = CalibratedRange::by_all(identity.calibrations(), &identity.codes);
    let rate_hz = config.timing.rate_hz;
    let mut alone = SingleActuator {
        actuator,
        rate_hz,
        steps: (trajectory.seconds() * rate_hz) as usize,
        readings: CrossReadings::new(&identity, actuator, rate_hz, shown.frozen_m),
        identity,
        ticks: Ticks::new(),
    };
    alone.arm(board, operator, &config)?;
    alone.wait_for_go(board, operator)?;
    let mut played = alone.play(board, observer)?;
    played.stiffness_n_per_m = alone.readings.stiffness_n_per_m();
    played.suspicion = alone.wiring_mistake(test);
    Ok(played)
}

/// Who ends a signal that is played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    /// The signal itself, or the board's button.
    Playing,
    /// A person at the PC, who has stopped it: the board is on its way to rest.
    StoppedByHand,
}

/// One actuator that moves while the others stand still.
struct SingleActuator {
    actuator: usize,
    rate_hz: f64,
    /// Steps of the signal.
    steps: usize,
    identity: Identity,
    readings: CrossReadings,
    ticks: Ticks,
}

impl SingleActuator {
    /// The next step, if one has come. Fails if the board has restarted.
    fn step<P: Port>(
        &mut self,
        board: &mut Connection<P>,
    ) -> Result<Option<(u32, StepReport)>, Failure> {
        let step = board.step()?;
        if let Some((tick, step)) = &step {
            if self.ticks.take(*tick).is_none() {
                return Err(started_again(board));
            }
            self.readings.look_for_rails(&self.identity, step);
        }
        Ok(step)
    }

    /// Reads the rig at rest; gives the last step.
    fn at_rest<P: Port>(&mut self, board: &mut Connection<P>) -> Result<StepReport, Failure> {
        let mut idle = 0;
        loop {
            if interrupt::asked() {
                return Err(given_up());
            }
            if let Some((_, step)) = self.step(board)? {
                idle += 1;
                if idle >= IDLE_STEPS {
                    return Ok(step);
                }
            }
        }
    }

    fn arm<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        operator: &Operator,
        config: &Config,
    ) -> Result<(), Failure> {
        interrupt::watch_rig();
        board.forget_steps();
        let mut latest = self.at_rest(board)?;
        let identity = self.identity.clone();
        let stand = |step: &StepReport| Standing::of(&identity, MAX_ACTUATORS, step, config);
        operator.ask(&stand(&latest).question());
        while !operator.lets_arm(&stand(&latest))? {
            if interrupt::asked() {
                return Err(given_up());
            }
            if let Some((_, step)) = self.step(board)? {
                latest = step;
            }
        }
        event(board, Event::Arm)?;
        board.forget_steps();
        let mut before = Mode::Idle;
        loop {
            if interrupt::asked() {
                event(board, Event::Stop)?;
                return Err(Failure::test(
                    "the approach to zero was given up, and the board is idle",
                ));
            }
            match self.step(board)?.map(|(_, s)| (s.mode(), s.command_m)) {
                Some((Some(Mode::Armed), 0.0)) => return Ok(()),
                Some((Some(Mode::Approaching), _)) => before = Mode::Approaching,
                // Telemetry of the steps before arming has all been read.
                Some((Some(Mode::Idle), _)) if before == Mode::Approaching => {
                    return Err(Failure::test(
                        "the approach to zero was ended by the board's button, and the board is idle",
                    ));
                }
                Some((Some(Mode::Tripped), _)) => {
                    return Err(Failure::test(format!(
                        "the board tripped on its way to zero: {}",
                        self.reason(status(board)?.trip)
                    )));
                }
                _ => {}
            }
        }
    }

    /// The rig stands at zero, armed. The actuator moves when the person says so.
    fn wait_for_go<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        operator: &Operator,
    ) -> Result<(), Failure> {
        let which = match self.identity.actuators() {
            1 => String::new(),
            all => format!(
                " of actuator {} of {all}, and the others stand",
                self.actuator + 1
            ),
        };
        operator.ask(&format!(
            "the rig stands at zero, armed: Enter starts the signal{which}; Ctrl-C gives it up"
        ));
        loop {
            match operator.lets_start("the signal was given up before its start") {
                Ok(true) => return Ok(()),
                Ok(false) => {}
                Err(why) => {
                    event(board, Event::Stop)?;
                    return Err(why);
                }
            }
            match self.step(board)?.and_then(|(_, step)| step.mode()) {
                Some(Mode::Idle) => {
                    return Err(Failure::test(
                        "the signal was ended before its start by the board's button, and the board is idle",
                    ));
                }
                Some(Mode::Tripped) => {
                    return Err(Failure::test(format!(
                        "the board tripped before the start: {}",
                        self.reason(status(board)?.trip)
                    )));
                }
                _ => {}
            }
        }
    }

    /// The signal, from its start until the board is idle again or tripped. Whatever ends it, what was received is kept.
    fn play<P: Port>(
        &mut self,
        board: &mut Connection<P>,
        observer: &mut dyn TestObserver,
    ) -> Result<Played, Failure> {
        let started = event(board, Event::Start)?;
        let mut phase = Phase::Playing;
        let mut played = Played::new();
        let mut begin = None;
        let early = loop {
            if phase == Phase::Playing && interrupt::asked() {
                // Refused only by a board that has already ended the signal, and then the telemetry says how.
                let _ = event(board, Event::Stop);
                phase = Phase::StoppedByHand;
            }
            let (tick, step) = match self.step(board) {
                Ok(Some(step)) => step,
                Ok(None) => continue,
                Err(lost) => break Some(lost.to_string()),
            };
            let record = self.record(tick, &step);
            observer.on_step(&(&record).into());
            // Refused only by a board that has already ended the signal.
            if let Some(asked) = observer.requested_event()
                && event(board, asked).is_ok()
            {
                phase = Phase::StoppedByHand;
            }
            match step.mode() {
                Some(Mode::Commissioning) => {
                    let begin = *begin.get_or_insert(tick);
                    let time_s = f64::from(tick.wrapping_sub(begin)) / self.rate_hz;
                    let ([displacement_m], [force_n]) = (record.displacement_m, record.force_n);
                    played.add_at(time_s, step.command_m, displacement_m, force_n);
                    self.readings.add_step(&self.identity, &step);
                }
                Some(Mode::Finished) => {
                    let early = match phase {
                        Phase::Playing => self.cut_short(tick.wrapping_sub(started) as usize),
                        Phase::StoppedByHand => Some(Played::BY_HAND.to_owned()),
                    };
                    let rest = self.come_to_rest(board);
                    break rest
                        .unwrap_or_else(|failure| Some(failure.to_string()))
                        .or(early);
                }
                Some(Mode::Tripped) => break Some(self.tripped(board, step.fault())),
                _ => {}
            }
        };
        Ok(Played { early, ..played })
    }

    /// The reason, if the signal had fewer steps than planned.
    fn cut_short(&self, steps: usize) -> Option<String> {
        // Nothing else ends a signal that has not tripped.
        (steps + SHORT_STEPS < self.steps).then(|| Played::BY_BUTTON.to_owned())
    }

    /// Makes the board idle, and so drops PERMIT, when the command stands still. Gives the reason if the board trips
    /// before that.
    fn come_to_rest<P: Port>(
        &mut self,
        board: &mut Connection<P>,
    ) -> Result<Option<String>, Failure> {
        let (mut standing, mut last_m) = (0, f32::NAN);
        while standing < REST_STEPS {
            let Some((_, step)) = self.step(board)? else {
                continue;
            };
            match step.mode() {
                Some(Mode::Finished) => {}
                // The reason for a trip is reported when the rig stands still.
                Some(Mode::Stopping) => continue,
                Some(Mode::Tripped) => return Ok(Some(self.tripped(board, step.fault()))),
                _ => break,
            }
            standing = if step.command_m == last_m {
                standing + 1
            } else {
                0
            };
            last_m = step.command_m;
        }
        clear(board).map(|()| None)
    }

    /// The sentence for a trip; `fault`: what the telemetry says, used if the board gives no reason.
    fn tripped<P: Port>(&self, board: &mut Connection<P>, fault: Option<Fault>) -> String {
        let trip = status(board).ok().and_then(|now| now.trip);
        let reason = match (trip, fault) {
            (None, Some(fault)) => fault.name().into(),
            (trip, _) => self.reason(trip),
        };
        format!("the board tripped: {reason}")
    }

    /// A step as a record of the actuator that moves.
    fn record(&self, tick: u32, step: &StepReport) -> Record<1> {
        let mut record = Record::<1>::EMPTY;
        (record.tick, record.flags) = (tick, step.flags);
        (record.command_m, record.sent_m) = ([step.command_m], [step.command_m]);
        let codes = step.codes(self.actuator).unwrap_or_default();
        if let Some(lines) = self.identity.calibrations().nth(self.actuator) {
            [record.displacement_m, record.force_n] = lines.readings(codes).map(|x| [x]);
        }
        record
    }

    /// What looks wrongly wired; on a board with one actuator only its polarity can be seen.
    fn wiring_mistake(&self, test: &TestFile) -> Option<String> {
        let structure = &test.config.structure;
        let storeys = &structure.stiffness_n_per_m;
        let physical = test.config.physical_storeys().min(storeys.len());
        self.readings.wiring_mistake(&storeys[..physical])
    }

    /// Why the board tripped, and on which actuator.
    fn reason(&self, trip: Option<Trip>) -> String {
        let Some(trip) = trip else {
            return "see `outerloop board status`".into();
        };
        let several = self.identity.actuators() > 1;
        let name = trip.fault.name();
        match (self.readings.rail(), trip.limited_axis()) {
            (Some(which), _) if trip.fault == Fault::AdcRail => format!("{name}: {which}"),
            (_, Some(axis)) if several => format!("{name} of actuator {}", axis + 1),
            _ => name.into(),
        }
    }
}
