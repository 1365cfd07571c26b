//! The emulator's translations for one board are used for the next one, and do not change what it does.

use crate::desk::{Bench, Desk, image};
use emu::{CoreBits, Firmware, LoggedEvent};
use outerloop_core::Mode;

/// The image with a few bytes after it: no other test runs it, so the first board gets a new processor.
fn marked(mark: &[u8; 8]) -> Firmware {
    let firmware = Firmware::read(image()).unwrap();
    firmware.with_flash(0x080f_fff0, mark.to_vec()).unwrap()
}

#[test]
fn the_second_board_does_the_same_at_the_same_instants() {
    let [first, second] = [(); 2].map(|()| {
        let mut desk = Desk::with(Bench {
            firmware: Some(marked(b"instants")),
            ..Bench::default()
        });
        desk.start();
        desk.until(Mode::Running);
        for _ in 0..1000 {
            desk.step();
        }
        (desk.steps.clone(), desk.log())
    });
    assert_eq!(first.0, second.0);
    let (first, second) = (first.1, second.1);
    assert!(first.triggers_ns.len() > 1000);
    assert_eq!(first.triggers_ns, second.triggers_ns);
    assert_eq!(first.latency_ns, second.latency_ns);
    assert_eq!(first.step_instructions, second.step_instructions);
    assert_eq!(first.seen, second.seen);
    assert_eq!(first.position_m, second.position_m);
}

#[test]
fn an_instruction_that_one_board_has_lost_is_there_on_the_next() {
    let interrupt = marked(b"an order").symbol("ADC").unwrap() & !1;
    let run = |is_broken: bool| {
        let processor = CoreBits::default();
        let mut desk = Desk::with(Bench {
            firmware: Some(marked(b"an order")),
            processor: Some(processor.clone()),
            ..Bench::default()
        });
        desk.start();
        desk.until(Mode::Running);
        if is_broken {
            processor.turn_over_byte(interrupt + 1, 7);
        }
        for _ in 0..400 {
            desk.turn();
        }
        let was_reset = |(_, seen): &(u64, LoggedEvent)| *seen == LoggedEvent::Reset;
        desk.log().seen.iter().any(was_reset)
    };
    assert!(
        run(true),
        "the control interrupt has lost its first instruction"
    );
    assert!(!run(false));
}
