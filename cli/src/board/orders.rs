//! Commands from a person to a board, and the sentence for a refusal.

use super::connection::Connection;
use super::port::Port;
use super::wording::describe_start;

use experiment::failure::Failure;
use link::command::Channel;
use link::reply::{Identity, Obstacle, Reply};
use link::{Calibration, Command, Status};
use outerloop_core::{Event, Mode};

/// The board's identity; a board of another release is refused.
///
/// # Errors
/// As [`Connection::ask`]; firmware of another release.
pub fn identify<P: Port>(board: &mut Connection<P>) -> Result<Identity, Failure> {
    let identity = match board.ask(&Command::Identify)? {
        Reply::Identity(identity) => identity,
        other => return Err(refused("identify", other)),
    };
    let own = env!("CARGO_PKG_VERSION");
    if identity.version != own {
        return Err(Failure::input(format!(
            "the board's firmware is version {}, this program {own}: accepted is firmware of the same release",
            identity.version
        )));
    }
    Ok(identity)
}

/// The board's status.
///
/// # Errors
/// As [`Connection::ask`].
pub fn status<P: Port>(board: &mut Connection<P>) -> Result<Status, Failure> {
    match board.ask(&Command::Status)? {
        Reply::Status(status) => Ok(status),
        other => Err(refused("status", other)),
    }
}

/// The failure for a board that has restarted while something ran on it, with the reason.
pub fn started_again<P: Port>(board: &mut Connection<P>) -> Failure {
    let why = status(board).map_or_else(|e| e.to_string(), |now| describe_start(&now));
    Failure::test(format!(
        "the board has started again, and what ran on it is over: {why}"
    ))
}

/// Clears the end of a test, or a fault, so that the board is idle.
///
/// # Errors
/// As [`Connection::ask`]; a running test.
pub fn clear<P: Port>(board: &mut Connection<P>) -> Result<(), Failure> {
    match status(board)?.mode {
        Mode::Idle => Ok(()),
        Mode::Finished | Mode::Tripped => event(board, Event::Clear).map(drop),
        mode => Err(Failure::test(format!(
            "clear: the board is {}: accepted are finished and tripped",
            mode.name()
        ))),
    }
}

/// Replaces the calibration of every actuator by the same one.
///
/// # Errors
/// As [`calibrate_one`].
pub fn calibrate<P: Port>(
    board: &mut Connection<P>,
    calibration: Calibration,
) -> Result<(), Failure> {
    (0..identify(board)?.actuators())
        .try_for_each(|actuator| calibrate_one(board, actuator as u8, calibration))
}

/// Replaces the calibration of an actuator, numbered from 0.
///
/// # Errors
/// As [`Connection::ask`]; a calibration that is refused; a board that is not idle or has no such actuator.
pub fn calibrate_one<P: Port>(
    board: &mut Connection<P>,
    actuator: u8,
    calibration: Calibration,
) -> Result<(), Failure> {
    let order = Command::Calibrate(actuator, calibration);
    done(board, "calibrate", &order).map(drop)
}

/// Makes the present reading of an actuator's `channel` the given value (m or N); gives the mean code and its spread.
///
/// # Errors
/// As [`Connection::ask`]; a board that is not idle.
pub fn zero<P: Port>(
    board: &mut Connection<P>,
    actuator: u8,
    channel: Channel,
    value: f32,
) -> Result<(f32, u16), Failure> {
    match board.ask(&Command::Zero {
        actuator,
        channel,
        value,
    })? {
        Reply::Zeroed { code, spread } => Ok((code, spread)),
        other => Err(refused("zero", other)),
    }
}

/// Saves the calibration, and the test if there is one, so that they survive power-off.
///
/// # Errors
/// As [`Connection::ask`]; a board that is not idle or has neither; a memory that cannot store them.
pub fn save<P: Port>(board: &mut Connection<P>) -> Result<(), Failure> {
    done(board, "save", &Command::Save).map(drop)
}

/// Sends an event; gives the first control step with it.
///
/// # Errors
/// As [`Connection::ask`]; an event that is refused.
pub(super) fn event<P: Port>(board: &mut Connection<P>, event: Event) -> Result<u32, Failure> {
    let what = match event {
        Event::Arm => "arm",
        Event::Start => "start",
        Event::Hold => "hold",
        Event::Stop => "stop",
        Event::Finish => "finish",
        Event::Fault => "fault",
        Event::Clear => "clear",
        Event::MinorFault => "minor fault",
    };
    done(board, what, &Command::Event(event))
}

/// Has a command carried out; gives the first control step with it.
///
/// # Errors
/// As [`Connection::ask`]; a command that is refused.
pub(crate) fn done<P: Port>(
    board: &mut Connection<P>,
    what: &str,
    command: &Command,
) -> Result<u32, Failure> {
    match board.ask(command)? {
        Reply::Done { tick, .. } => Ok(tick),
        other => Err(refused(what, other)),
    }
}

/// Why nothing was done, in one sentence.
fn refused(what: &str, reply: Reply) -> Failure {
    match reply {
        Reply::Refused(parameter) => Failure::input(parameter.to_string()),
        Reply::Rejected {
            obstacle: Some(obstacle),
            ..
        } => Failure::test(match obstacle {
            Obstacle::Fault(fault) => format!(
                "{what}: the interlock {} stands against it: accepted is a rig at rest within its limits",
                fault.name()
            ),
            Obstacle::NotCalibrated => format!(
                "{what}: nobody has calibrated the board, or what was saved last is damaged: accepted is one with a calibration, see `outerloop board calibrate --help`"
            ),
            Obstacle::NotConfigured => {
                format!(
                    "{what}: the board has no test: accepted is a board that has been configured"
                )
            }
            Obstacle::NothingToRun => format!(
                "{what}: the board has neither a ground motion nor a signal: accepted is one of them"
            ),
            Obstacle::Crystal => format!(
                "{what}: the board's crystal has the wrong frequency: accepted is 8 MHz from the ST-LINK"
            ),
            Obstacle::Converters => format!(
                "{what}: a converter outside the chip did not answer when the board started: accepted is one that has power and all its wires, then a reset of the board (docs/wiring-16.md)"
            ),
        }),
        Reply::Rejected { mode, .. } => Failure::test(format!(
            "{what}: means nothing while the board is {}: accepted is another order first, see `outerloop board status`",
            mode.name()
        )),
        Reply::WrongSum { received } => Failure::test(format!(
            "{what}: the ground motion came to the board with the check sum {received:08x}: accepted is what was sent; try again"
        )),
        other => Failure::test(format!("{what}: the board answers with {other:?}")),
    }
}
