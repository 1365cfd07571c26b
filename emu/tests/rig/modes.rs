//! Every event in every mode, sent to the flashed image over its link: it does what the table of modes says.

use crate::desk::{Bench, Desk, config};
use link::Command;
use link::command::{CommissioningSignal, SignalShape};
use link::reply::Reply;
use outerloop_core::{Event, Method, Mode};

/// So slow that a mode which ends by itself lasts until all events have been sent.
const SLOW_M_PER_S: f64 = 0.5e-3;

/// So gentle that the ramp to hold lasts longer than that.
const SLOW_M_PER_S2: f64 = 1.0;

/// Whether the mode ends without an event, and would do so too soon.
fn ends_by_itself(mode: Mode) -> bool {
    matches!(mode, Mode::Approaching | Mode::Returning | Mode::Stopping)
}

/// A board prepared for `mode`. For approaching it has sunk some millimetres.
fn board(mode: Mode) -> Desk {
    let mut desk = Desk::with(Bench {
        sinks_m_per_s: if mode == Mode::Approaching { 0.02 } else { 0.0 },
        longest_s: 90,
        ..Bench::default()
    });
    desk.load();
    let mut config = config();
    // A predictor, which is faded in again after a hold.
    config.compensation.kind = Method::Tangent;
    if ends_by_itself(mode) {
        config.timing.approach_m_per_s = SLOW_M_PER_S;
    }
    if mode == Mode::Stopping {
        config.timing.hold_deceleration_m_per_s2 = SLOW_M_PER_S2;
    }
    desk.order(Command::Configure(config.into()));
    wait(&mut desk, 300);
    desk
}

fn wait(desk: &mut Desk, steps: usize) {
    for _ in 0..steps {
        desk.step();
    }
}

/// From idle to `mode`, the shortest way.
fn go(desk: &mut Desk, mode: Mode) {
    if mode == Mode::Commissioning {
        let sine = CommissioningSignal {
            actuator: 0,
            shape: SignalShape::Sine { frequency_hz: 2.0 },
            amplitude_m: 0.002,
            seconds: 3.0,
        };
        desk.order(Command::Signal(Some(sine)));
    }
    let way: &[Event] = match mode {
        Mode::Idle => &[],
        Mode::Approaching | Mode::Armed => &[Event::Arm],
        Mode::Running | Mode::Commissioning => &[Event::Arm, Event::Start],
        Mode::Holding => &[Event::Arm, Event::Start, Event::Hold],
        Mode::Returning | Mode::Resuming => &[Event::Arm, Event::Start, Event::Hold, Event::Start],
        Mode::Finished => &[Event::Arm, Event::Start, Event::Stop],
        Mode::Stopping => &[Event::Arm, Event::Start, Event::MinorFault],
        Mode::Tripped => &[Event::Arm, Event::Fault],
    };
    for event in way {
        match event {
            Event::Start if mode != Mode::Returning && mode != Mode::Resuming => {
                desk.until(Mode::Armed);
                while desk.step().command_m != 0.0 {}
            }
            // In full motion: the ramp ends away from the test's motion.
            Event::Hold | Event::MinorFault => wait(desk, 700),
            // It stands.
            Event::Start if desk.status().mode == Mode::Holding => {
                wait(desk, 400);
            }
            Event::Start => desk.until(Mode::Armed),
            // Obstacles must have been gone for a while.
            Event::Arm => wait(desk, 300),
            Event::Stop | Event::Finish | Event::Fault | Event::Clear => {}
        }
        desk.order(Command::Event(*event));
    }
    desk.until(mode);
    if mode == Mode::Idle {
        wait(desk, 300);
    }
}

/// Back to idle from any mode.
fn home(desk: &mut Desk) {
    loop {
        let event = match desk.status().mode {
            Mode::Idle => return,
            Mode::Finished | Mode::Tripped => Event::Clear,
            Mode::Stopping => {
                desk.step();
                continue;
            }
            Mode::Armed
            | Mode::Running
            | Mode::Holding
            | Mode::Approaching
            | Mode::Returning
            | Mode::Resuming
            | Mode::Commissioning => Event::Stop,
        };
        desk.order(Command::Event(event));
    }
}

/// What is wrong with the reply to `event` in `mode`, by the table.
fn wrong(mode: Mode, event: Event, reply: &Reply) -> Option<String> {
    let right = match (mode.after(event), reply) {
        (Ok(after), Reply::Done { mode: now, .. }) => *now == after || ends_at_once(after, *now),
        (
            Err(_),
            Reply::Rejected {
                mode: now,
                event: told,
                ..
            },
        ) => (*now, *told) == (mode, Some(event)),
        _ => false,
    };
    let said = mode.after(event).ok();
    (!right).then(|| format!("{mode:?} {event:?}: {said:?}, and the board says {reply:?}"))
}

/// If there is nothing to do in a mode, the reply has the mode after it.
fn ends_at_once(mode: Mode, behind: Mode) -> bool {
    matches!(
        (mode, behind),
        // The rig is at the start already.
        (Mode::Approaching, Mode::Armed)
        // At standstill there is no ramp.
        | (Mode::Stopping, Mode::Tripped)
    )
}

/// The board in `mode` does with `event` what the table says.
fn holds(desk: &mut Desk, mode: Mode, event: Event) {
    let reply = desk.ask(Command::Event(event));
    assert_eq!(wrong(mode, event, &reply), None);
    if let Reply::Done { .. } = reply {
        let status = desk.status();
        let permits = status.mode.permits_motion();
        assert_eq!(status.permit, permits, "{mode:?} {event:?}");
    }
}

// proves: mode.*
#[test]
fn every_event_in_every_mode_does_on_the_board_what_the_table_says() {
    for mode in Mode::ALL {
        let mut desk = board(mode);
        go(&mut desk, mode);
        let (leads_on, refused): (Vec<Event>, Vec<Event>) =
            Event::ALL.into_iter().partition(|e| mode.after(*e).is_ok());
        for event in refused {
            holds(&mut desk, mode, event);
        }
        for (place, event) in leads_on.into_iter().enumerate() {
            if place > 0 {
                if ends_by_itself(mode) {
                    // The way back would be as slow.
                    desk = board(mode);
                } else {
                    home(&mut desk);
                    wait(&mut desk, 100);
                }
                go(&mut desk, mode);
            }
            holds(&mut desk, mode, event);
        }
        println!("{mode:?}: {} events", Event::ALL.len());
    }
}

/// The check above would reject a board with any other table: each pair leads elsewhere.
#[test]
fn a_board_that_does_anything_else_is_seen() {
    for (mode, event) in Mode::ALL
        .into_iter()
        .flat_map(|m| Event::ALL.map(|e| (m, e)))
    {
        let refused = Reply::Rejected {
            mode,
            event: Some(event),
            obstacle: None,
        };
        let done = Mode::ALL.map(|mode| Reply::Done { tick: 0, mode });
        let replies = done.into_iter().chain([refused]);
        let unseen = replies.filter(|reply| wrong(mode, event, reply).is_none());
        // The right one, and in these also the mode after it; another scenario waits for the approach.
        let expected = match mode.after(event) {
            Ok(Mode::Approaching | Mode::Stopping) => 2,
            Ok(_) | Err(_) => 1,
        };
        assert_eq!(unseen.count(), expected, "{mode:?} {event:?}");
    }
}
