//! A converter outside the chip that does not answer.

use crate::desk::{Bench, Desk};
use link::Command;
use link::reply::{Obstacle, Reply};
use outerloop_core::Event;

#[test]
fn a_converter_without_its_reset_does_not_answer_and_nothing_can_be_armed() {
    use emu::registers::GPIOF_MODER;
    let mut desk = Desk::with(Bench {
        mutant: Some(emu::Mutant {
            address: GPIOF_MODER,
            clear: 3 << 24,
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
        "{reply:?}"
    );
}
