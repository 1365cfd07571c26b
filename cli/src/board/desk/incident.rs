//! Incidents in the middle of a test on a board, and the state that each must lead to.

use super::{DeskRow, STOPPED_STEPS, calibration, configure, experiment, forget, give_up, pass};
use crate::board::connection::BoardConnection;
use crate::board::orders::{calibrate, clear, done, event, identify, status};
use crate::board::upload::load;
use crate::terminal::interrupt;
use experiment::failure::Failure;
use link::Command;
use link::status::{CrashCause, StartCause, Status};
use outerloop_core::{Event, Fault, Mode};
use serde::{Deserialize, Serialize};

/// A board that has not restarted within this many steps was not reset: half a minute, for a person to find the button.
const RESET_STEPS: u32 = 60_000;

/// Reads of the telemetry, some milliseconds each, within which the desk's test stands at its start, or runs.
const REACHED_STEPS: u32 = 10_000;

/// What is done to a board from outside in the middle of a test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Incident {
    /// A drill of the firmware, started by a write into its memory.
    Drill(u32),
    /// The reset pin.
    Reset,
}

/// What an incident must lead to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Leaves {
    /// The board restarts, and reports how and why it crashed.
    Start(StartCause, Option<CrashCause>),
    /// The board does not restart, and has tripped.
    Trip(Fault),
}

/// All incidents, with what each must lead to.
pub const INCIDENTS: [(Incident, &str, Leaves); 9] = [
    (
        Incident::Drill(1),
        "a panic",
        Leaves::Start(StartCause::Watchdog, Some(CrashCause::Panic)),
    ),
    (
        Incident::Drill(2),
        "an undefined instruction",
        Leaves::Start(StartCause::Watchdog, Some(CrashCause::HardFault)),
    ),
    (
        Incident::Drill(3),
        "a stack without end",
        Leaves::Start(StartCause::Watchdog, Some(CrashCause::StackOverflow)),
    ),
    (
        Incident::Drill(4),
        "a task that starves the others",
        Leaves::Start(StartCause::Watchdog, Some(CrashCause::Starved)),
    ),
    (
        Incident::Drill(5),
        "interrupts off for good",
        Leaves::Start(StartCause::Watchdog, Some(CrashCause::Silent)),
    ),
    (
        Incident::Drill(6),
        "a step that takes too long",
        Leaves::Trip(Fault::DeadlineMissed),
    ),
    (
        Incident::Drill(7),
        "the external clock's guard",
        Leaves::Start(StartCause::Watchdog, Some(CrashCause::ClockStopped)),
    ),
    (
        Incident::Drill(8),
        "the supply's guard",
        Leaves::Start(StartCause::Watchdog, Some(CrashCause::LowSupply)),
    ),
    (
        Incident::Reset,
        "the reset pin",
        Leaves::Start(StartCause::Pin, None),
    ),
];

/// Runs a test, applies the incident with `happens`, and reports the board's state afterwards.
pub fn row(
    board: &mut BoardConnection,
    (incident, name, leaves): (Incident, &str, Leaves),
    happens: impl FnOnce(Incident, &mut BoardConnection) -> Result<(), Failure>,
) -> DeskRow {
    let found = (|| {
        run_until_moving(board)?;
        happens(incident, board)?;
        match leaves {
            Leaves::Start(started, cause) => {
                until_reset(board)?;
                let now = status(board)?;
                let died = now.last_crash.as_ref().map(|crash| crash.cause);
                let good = (now.started, died, now.permit) == (started, cause, false);
                Ok((said(&now), good && now.mode == Mode::Idle))
            }
            Leaves::Trip(fault) => {
                until_tripped(board)?;
                let now = status(board)?;
                let tripped = now.trip.map(|t| t.fault);
                let level = if now.permit { "high" } else { "low" };
                let name = tripped.map_or("none", Fault::name);
                let said = format!("{}, fault {name}, PERMIT {level}", now.mode.name());
                clear(board)?;
                forget(board);
                Ok((said, (tripped, now.permit) == (Some(fault), false)))
            }
        }
    })();
    if found.is_err() {
        give_up(board);
    }
    let limit = match leaves {
        Leaves::Start(started, cause) => format!(
            "starts again by {started:?}, PERMIT low, crash report {}",
            cause.map_or("none".into(), |c| format!("{c:?}"))
        ),
        Leaves::Trip(fault) => format!("tripped, fault {}, PERMIT low", fault.name()),
    };
    DeskRow::of(format!("in a running test: {name}"), &limit, found)
}

fn said(now: &Status) -> String {
    let level = if now.permit { "high" } else { "low" };
    let report = now.last_crash.as_ref().map_or("none".into(), |crash| {
        format!("{:?}, {}", crash.cause, crash.text)
    });
    format!(
        "started again by {:?}, {}, PERMIT {level}, crash report {report}",
        now.started,
        now.mode.name()
    )
}

/// Arms and starts the desk's test.
fn run_until_moving(board: &mut BoardConnection) -> Result<(), Failure> {
    let experiment = experiment(4.0, 2000)?;
    let codes = identify(board)?.codes;
    calibrate(board, calibration(&codes))?;
    configure(board, &experiment)?;
    let shaking = experiment.shaking();
    load(board, shaking.acc_m_per_s2, shaking.interval_s)?;
    done(board, "signal", &Command::Signal(None))?;
    pass(board, 300)?;
    event(board, Event::Arm)?;
    until(board, |mode, command_m| {
        mode == Mode::Armed && command_m == 0.0
    })?;
    event(board, Event::Start)?;
    until(board, |mode, _| mode == Mode::Running)
}

fn until(board: &mut BoardConnection, reached: impl Fn(Mode, f32) -> bool) -> Result<(), Failure> {
    for _ in 0..REACHED_STEPS {
        if interrupt::asked() {
            return Err(Failure::test("given up"));
        }
        for (_, step) in board.steps()? {
            match step.mode() {
                Some(Mode::Tripped) => {
                    return Err(Failure::test("the board tripped before anything was done"));
                }
                Some(mode) if reached(mode, step.command_m) => return Ok(()),
                _ => {}
            }
        }
    }
    Err(Failure::test(
        "the test of the desk did not start: the board's button has ended it, or the board has started again",
    ))
}

/// Waits until the step count starts from zero again.
fn until_reset(board: &mut BoardConnection) -> Result<(), Failure> {
    let (mut last, mut seen) = (0, 0);
    while seen < RESET_STEPS {
        for (tick, _) in board.steps()? {
            if tick < last {
                return Ok(());
            }
            (last, seen) = (tick, seen + 1);
        }
    }
    Err(Failure::test("the board was not reset"))
}

fn until_tripped(board: &mut BoardConnection) -> Result<(), Failure> {
    let mut seen = 0;
    while seen < STOPPED_STEPS {
        for (_, step) in board.steps()? {
            if step.mode() == Some(Mode::Tripped) {
                return Ok(());
            }
            seen += 1;
        }
    }
    Err(Failure::test("the board has not tripped"))
}
