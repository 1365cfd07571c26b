//! Images for three actuators with one register wrong: each is seen for what it is.

use crate::mutant::Does::{Runs, SamplesNothing, ShowsNothing, WritesNothing};
use crate::mutant::{Case, each_is_seen};
use crate::silent::is_noticed;
use emu::registers::*;

const CASES: [Case; 9] = [
    ("TIM2_CCMR2.OC3M", TIM2_CCMR2, 7 << 4, 0, SamplesNothing),
    // The fall of BUSY is not seen: no sample is valid.
    (
        "GPIOB_AFRH.PB11",
        GPIOB_AFRH,
        15 << 12,
        2 << 12,
        WritesNothing,
    ),
    ("GPIOD_AFRH.PD12", GPIOD_AFRH, 15 << 16, 0, ShowsNothing),
    ("TIM4_CCER.CC1P", TIM4_CCER, 2, 0, Runs),
    // 60 us, correct for one actuator: the last of three commands may not be written by then.
    ("TIM4_CCR1", TIM4_CCR1, 0xffff, 5040, Runs),
    ("SPI1_CR1.BR", SPI1_CR1, 7 << 3, 1 << 3, Runs),
    // The commands read back: these tests do not depend on them.
    ("ADC2_CR2.JEXTEN", ADC2_CR2, 3 << 20, 0, Runs),
    ("ADC2_JSQR", ADC2_JSQR, 31 << 5, 10 << 5, Runs),
    ("GPIOC_MODER.PC0", GPIOC_MODER, 3, 0, Runs),
];

#[test]
fn each_wrong_register_is_seen_for_what_it_is() {
    each_is_seen(&CASES);
}

/// SYNC drives nothing: the AD5754R receives no command.
#[test]
fn commands_that_do_not_reach_their_converter_are_noticed_and_nothing_can_be_armed() {
    is_noticed(GPIOD_MODER, 3 << 4);
}
