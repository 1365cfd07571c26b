//! A commissioning signal on a board: what was commanded, what moved, what pushed back.

use super::connection::Connection;
use super::orders::{clear, done, event, identify, status};
use super::port::Port;
use crate::failure::Failure;
use link::Command;
use link::command::Signal;
use outerloop_core::{Config, Event, State};
use std::fmt::Write as _;

/// Steps before arming.
const IDLE_STEPS: usize = 256;

/// Runs `signal` under the limits of `config`; returns the recording in the format of recorded data, and why it ended
/// early, if it did.
///
/// # Errors
/// A board that is refused or not idle; a signal that is refused; a link that is lost before the start.
pub fn commission<P: Port>(
    board: &mut Connection<P>,
    config: &Config,
    signal: Signal,
) -> Result<(String, Option<String>), Failure> {
    let identity = identify(board)?;
    clear(board)?;
    done(board, "configure", &Command::Configure(config.clone()))?;
    done(board, "signal", &Command::Signal(Some(signal)))?;
    board.forget_steps();
    let mut idle = 0;
    while idle < IDLE_STEPS {
        idle += usize::from(board.step()?.is_some());
    }
    event(board, Event::Arm)?;
    board.forget_steps();
    loop {
        match board.step()?.map(|(_, s)| (s.state(), s.command_m)) {
            Some((Some(State::Armed), 0.0)) => break,
            Some((Some(State::Tripped), _)) => {
                return Err(Failure::test(
                    "the board tripped on its way to zero: see `outerloop board status`",
                ));
            }
            _ => {}
        }
    }
    event(board, Event::Start)?;
    let mut text = String::from("time_s,command_m,displacement_m,force_n\n");
    let mut begin = None;
    let early = loop {
        let (tick, step) = match board.step() {
            Ok(Some(step)) => step,
            Ok(None) => continue,
            Err(lost) => break Some(lost.to_string()),
        };
        match step.state() {
            Some(State::Commissioning) => {
                let begin = *begin.get_or_insert(tick);
                let _ = writeln!(
                    text,
                    "{},{},{},{}",
                    f64::from(tick.wrapping_sub(begin)) / config.timing.rate_hz,
                    step.command_m,
                    identity
                        .calibration
                        .displacement
                        .quantity(step.displacement),
                    identity.calibration.force.quantity(step.force)
                );
            }
            Some(State::Finished) => break None,
            Some(State::Tripped) => {
                let fault = status(board)?.trip.map_or("a fault", |t| t.fault.name());
                break Some(format!("the board tripped on {fault}"));
            }
            _ => {}
        }
    };
    if early.is_none() {
        clear(board)?;
    }
    Ok((text, early))
}
