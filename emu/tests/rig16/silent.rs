//! An external converter that does not answer.

use crate::desk::{Bench, Desk};
use emu::Mutant;
use emu::registers::GPIOF_MODER;
use link::Command;
use link::reply::{Obstacle, Reply};
use outerloop_core::Event;

/// A board on which these bits of a register are zero notices that a converter is silent, and nothing can be armed.
pub fn is_noticed(address: u64, clear: u64) {
    let mut desk = Desk::with(Bench {
        mutant: Some(Mutant {
            address,
            clear,
            set: 0,
        }),
        ..Bench::default()
    });
    desk.load();
    assert!(!desk.status().converters_ok);
    let reply = desk.ask(Command::Event(Event::Arm));
    let silent = Some(Obstacle::Converters);
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == silent),
        "{address:#x}: {reply:?}"
    );
}

#[test]
fn a_converter_without_its_reset_does_not_answer_and_nothing_can_be_armed() {
    is_noticed(GPIOF_MODER, 3 << 24);
}
