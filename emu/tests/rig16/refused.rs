//! A converter outside the chip that is not as it was when the board started stands against arming.

use crate::desk::{Bench, Desk, STIFFNESS_N_PER_M};
use emu::{InjectedFault, PlannedFault};
use link::Command;
use link::reply::{Obstacle, Reply};
use outerloop_core::Event;

/// How fast the force on a rig that sinks grows, N/s: its limit is far away when it has sunk by some millimetres.
const SINKS_N_PER_S: f64 = 3160.0;

/// A rig that has sunk by some millimetres, and a fault that is there from the first sample on. Gives the board with a test
/// in it.
pub fn loaded(fault: InjectedFault) -> Desk {
    sinking(fault, SINKS_N_PER_S / STIFFNESS_N_PER_M)
}

fn sinking(fault: InjectedFault, sinks_m_per_s: f64) -> Desk {
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 0,
            fault,
        }),
        sinks_m_per_s,
        ..Bench::default()
    });
    desk.load();
    desk
}

/// Arming is refused for this reason, and nothing has moved but what sinks.
pub fn refuses(fault: InjectedFault, reason: Obstacle) {
    is_refused(loaded(fault), fault, reason);
}

/// The same of a rig that stays in the middle of its stroke, where an output at ground reads as one that is right.
pub fn refuses_in_the_middle(fault: InjectedFault, reason: Obstacle) {
    is_refused(sinking(fault, 0.0), fault, reason);
}

fn is_refused(mut desk: Desk, fault: InjectedFault, reason: Obstacle) {
    let reply = desk.ask(Command::Event(Event::Arm));
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == Some(reason)),
        "{fault:?}: {reply:?}"
    );
    for _ in 0..100 {
        desk.step();
    }
    let at_m = desk.log().position_m;
    let jump_m = at_m.windows(2).map(|w| (w[1] - w[0]).abs());
    assert!(jump_m.fold(0.0, f64::max) < 2e-5, "{fault:?}");
}
