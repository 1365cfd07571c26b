//! A commissioning signal on a board: what was commanded, what moved, what pushed back.

use super::connection::Connection;
use super::course::Course;
use super::limits::{self, Plan};
use super::operator::{Operator, catch_ctrl_c, stop_is_asked};
use super::orders::{clear, done, event, identify, status};
use super::played::Played;
use super::port::Port;
use crate::failure::Failure;
use crate::files::test::TestFile;
use crate::trace::Witness;
use link::Command;
use link::limits::Shown;
use outerloop_core::{Event, Mode, Record};

/// Steps for which the command has to stand after the end.
const REST_STEPS: u32 = 40;

/// Steps before arming.
const IDLE_STEPS: usize = 256;

/// Moves the actuator by `course` under the limits of `test`, or those that follow from the course.
///
/// # Errors
/// A course beyond a limit that the test states; a board that is refused or not idle; a signal that is refused; a link that
/// is lost before the start.
pub fn commission<P: Port>(
    board: &mut Connection<P>,
    test: &TestFile,
    course: &Course,
    operator: &Operator,
    witness: &mut impl Witness,
) -> Result<Played, Failure> {
    course.check(&test.config)?;
    let identity = identify(board)?;
    clear(board)?;
    let plan = Plan::of_course(test, course);
    let shown = Shown::by_all(identity.calibrations(), &identity.codes);
    let mut config = test.config.clone();
    config.limits = plan.limits(&test.config.limits, &shown);
    eprintln!(
        "outerloop: limits in force:\n{}",
        limits::describe(&test.config.limits, &config.limits)
    );
    done(board, "configure", &Command::Configure(config.clone()))?;
    course.send(board, &config)?;
    board.forget_steps();
    let mut idle = 0;
    while idle < IDLE_STEPS {
        idle += usize::from(board.step()?.is_some());
    }
    event(board, Event::Arm)?;
    board.forget_steps();
    loop {
        match board.step()?.map(|(_, s)| (s.state(), s.command_m)) {
            Some((Some(Mode::Armed), 0.0)) => break,
            Some((Some(Mode::Tripped), _)) => {
                return Err(Failure::test(
                    "the board tripped on its way to zero: see `outerloop board status`",
                ));
            }
            _ => {}
        }
    }
    catch_ctrl_c();
    operator.ask("the rig stands at zero, armed: Enter starts the signal, Ctrl-C gives it up");
    while !operator.agrees() {
        if stop_is_asked() {
            event(board, Event::Stop)?;
            return Err(Failure::test("the signal was given up before its start"));
        }
        if board
            .step()?
            .is_some_and(|(_, s)| s.state() == Some(Mode::Tripped))
        {
            return Err(Failure::test(
                "the board tripped before the start: see `outerloop board status`",
            ));
        }
    }
    event(board, Event::Start)?;
    let mut stopped = false;
    let mut played = Played::new();
    let mut begin = None;
    let early = loop {
        if stop_is_asked() && !std::mem::replace(&mut stopped, true) {
            event(board, Event::Stop)?;
        }
        let (tick, step) = match board.step() {
            Ok(Some(step)) => step,
            Ok(None) => continue,
            Err(lost) => break Some(lost.to_string()),
        };
        let calibration = &identity.calibration;
        let displacement_m = calibration.displacement.quantity(step.displacement);
        let force_n = calibration.force.quantity(step.force);
        let mut record = Record::<1>::EMPTY;
        (record.tick, record.flags) = (tick, step.flags);
        (record.command_m, record.sent_m) = ([step.command_m], [step.command_m]);
        (record.displacement_m, record.force_n) = ([displacement_m], [force_n]);
        witness.see(&record);
        if let Some(wish) = witness.wish() {
            // Refused only by a board that has ended the signal by itself.
            stopped |= event(board, wish).is_ok();
        }
        match step.state() {
            Some(Mode::Commissioning) => {
                let begin = *begin.get_or_insert(tick);
                let time_s = f64::from(tick.wrapping_sub(begin)) / config.timing.rate_hz;
                played.add_at(time_s, step.command_m, displacement_m, force_n);
            }
            Some(Mode::Finished) => break stopped.then(|| "it was stopped by hand".to_owned()),
            Some(Mode::Tripped) => {
                let fault = status(board)?.trip.map_or("a fault", |t| t.fault.name());
                break Some(format!("the board tripped on {fault}"));
            }
            _ => {}
        }
    };
    if early.is_none() || stopped {
        // Permission goes when the command stands.
        let (mut standing, mut last_m) = (0, f32::NAN);
        while standing < REST_STEPS {
            let Some((_, step)) = board.step()? else {
                continue;
            };
            if step.state() != Some(Mode::Finished) {
                break;
            }
            standing = if step.command_m == last_m {
                standing + 1
            } else {
                0
            };
            last_m = step.command_m;
        }
        clear(board)?;
    }
    Ok(Played { early, ..played })
}
