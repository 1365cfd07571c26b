//! Images for three actuators with one register wrong: each is seen for what it is.

use crate::desk::{Bench, Desk};
use crate::mutant::Does::{Runs, SamplesNothing, ShowsNothing};
use crate::mutant::{Case, each_is_seen};
use emu::Mutant;
use emu::registers::*;
use link::Command;
use link::reply::{Obstacle, Reply};
use outerloop_core::Event;

const CASES: [Case; 9] = [
    ("TIM2_CCMR2.OC3M", TIM2_CCMR2, 7 << 4, 0, SamplesNothing),
    // BUSY is not seen to fall: no sample counts, and the commands stand.
    (
        "GPIOB_AFRH.PB11",
        GPIOB_AFRH,
        15 << 12,
        2 << 12,
        ShowsNothing,
    ),
    ("GPIOD_AFRH.PD12", GPIOD_AFRH, 15 << 16, 0, ShowsNothing),
    ("TIM4_CCER.CC1P", TIM4_CCER, 2, 0, Runs),
    // 60 us, right for one actuator: the last of three commands may not be written by then.
    ("TIM4_CCR1", TIM4_CCR1, 0xffff, 5040, Runs),
    ("SPI1_CR1.BR", SPI1_CR1, 7 << 3, 1 << 3, Runs),
    // The commands read back: no part of the test hangs on them.
    ("ADC2_CR2.JEXTEN", ADC2_CR2, 3 << 20, 0, Runs),
    ("ADC2_JSQR", ADC2_JSQR, 31 << 5, 10 << 5, Runs),
    ("GPIOC_MODER.PC0", GPIOC_MODER, 3, 0, Runs),
];

/// Pins that drive nothing: SYNC, without which the AD5754R hears no command, and RESET, without which the AD7606 converts
/// nothing.
const SILENT: [(u64, u64); 2] = [(GPIOD_MODER, 3 << 4), (GPIOF_MODER, 3 << 24)];

#[test]
fn each_wrong_register_is_seen_for_what_it_is() {
    each_is_seen(&CASES);
}

#[test]
fn a_converter_that_does_not_answer_is_noticed_and_nothing_can_be_armed() {
    for (address, clear) in SILENT {
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
}
