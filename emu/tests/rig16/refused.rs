//! An external converter that has failed since the board started blocks arming.

use crate::desk::{Bench, Desk, STIFFNESS_N_PER_M};
use emu::{InjectedFault, PlannedFault};
use link::Command;
use link::reply::{Obstacle, Reply};
use outerloop_core::Event;

/// Rate of the force on a sinking rig, N/s: its limit is still far away after some millimetres.
const SINKS_N_PER_S: f64 = 3160.0;

/// A rig that has sunk by some millimetres, with a fault from the first sample. Returns the board with a test loaded.
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

/// Arming is refused for this reason, and the rig has only sunk.
pub fn refuses(fault: InjectedFault, reason: Obstacle) {
    is_refused(loaded(fault), fault, reason);
}

/// The same for a rig that stays in the middle of its stroke, where an output at ground reads back as correct.
pub fn refuses_in_the_middle(fault: InjectedFault, reason: Obstacle) {
    is_refused(sinking(fault, 0.0), fault, reason);
}

fn is_refused(mut desk: Desk, fault: InjectedFault, reason: Obstacle) {
    let reply = desk.ask(Command::Event(Event::Arm));
    for _ in 0..100 {
        desk.step();
    }
    let at_m = desk.log().position_m;
    let jumps_m = at_m.windows(2).map(|w| (w[1] - w[0]).abs());
    let jump_m = jumps_m.fold(0.0, f64::max);
    let said = format!("{fault:?}: {reply:?}, {:.2} mm in a period", jump_m * 1e3);
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == Some(reason)),
        "{said}"
    );
    assert!(jump_m < 2e-5, "{said}");
}
