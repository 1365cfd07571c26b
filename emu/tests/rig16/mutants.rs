//! Images for external converters with one register wrong: each is seen for what it is.

use crate::mutant::Does::{Runs, SamplesNothing, ShowsNothing, WritesNothing};
use crate::mutant::{Case, each_is_seen};
use emu::registers::*;

const CASES: [Case; 12] = [
    ("TIM2_CCMR2.OC3M", TIM2_CCMR2, 7 << 4, 0, SamplesNothing),
    ("TIM2_CCER.CC3E", TIM2_CCER, 1 << 8, 0, SamplesNothing),
    (
        "GPIOB_AFRH.PB10",
        GPIOB_AFRH,
        15 << 8,
        2 << 8,
        SamplesNothing,
    ),
    // The fall of BUSY is not seen: no sample is valid.
    (
        "GPIOB_AFRH.PB11",
        GPIOB_AFRH,
        15 << 12,
        2 << 12,
        WritesNothing,
    ),
    // A compare of channel 4 is taken for BUSY.
    ("TIM2_CCMR2.CC4S", TIM2_CCMR2, 3 << 8, 0, Runs),
    // The AD7606 was never reset.
    ("GPIOF_MODER.PF12", GPIOF_MODER, 3 << 24, 0, WritesNothing),
    ("TIM4_SMCR.SMS", TIM4_SMCR, 7, 0, ShowsNothing),
    ("TIM4_CR1.OPM", TIM4_CR1, 1 << 3, 0, ShowsNothing),
    ("GPIOD_AFRH.PD12", GPIOD_AFRH, 15 << 16, 0, ShowsNothing),
    ("TIM4_CCER.CC1P", TIM4_CCER, 2, 0, Runs),
    ("TIM4_CCR1", TIM4_CCR1, 0xffff, 1890, Runs),
    ("SPI1_CR1.BR", SPI1_CR1, 7 << 3, 1 << 3, Runs),
];

#[test]
fn each_wrong_register_is_seen_for_what_it_is() {
    each_is_seen(&CASES);
}
