//! Inputs recorded outside the control path: ADC2, triggered by TIM2, three ranks.

use super::*;

/// Without these ADC2 converts nothing, whichever inputs it has.
pub const CONVERTING: [Demand; 6] = [
    UPDATE_LEAVES,
    demand(
        "ADC2_CR2.JEXTSEL",
        ADC2_CR2,
        15 << 16,
        3 << 16,
        "another timer starts the further inputs' conversions",
    ),
    demand(
        "ADC2_CR2.JEXTEN",
        ADC2_CR2,
        3 << 20,
        1 << 20,
        "the timer's update starts no conversion of the further inputs",
    ),
    demand(
        "ADC2_CR2.ADON",
        ADC2_CR2,
        1,
        1,
        "the further inputs' converter is off",
    ),
    demand(
        "ADC2_CR1.SCAN",
        ADC2_CR1,
        1 << 8,
        1 << 8,
        "only the first further input is converted",
    ),
    demand(
        "ADC_CCR.ADCPRE",
        ADC_CCR,
        3 << 16,
        1 << 16,
        "the converter's clock is not 21 MHz: too fast, or not done in 10 us",
    ),
];

const fn ranks(name: &'static str, channels: [u64; 3]) -> Demand {
    let [first, second, third] = channels;
    demand(
        name,
        ADC2_JSQR,
        0x003f_ffe0,
        2 << 20 | third << 15 | second << 10 | first << 5,
        "the further inputs are not in their order",
    )
}

const fn sampled(name: &'static str, address: u64, place: u32, fails: &'static str) -> Demand {
    demand(name, address, 7 << (3 * place), 3 << (3 * place), fails)
}

const fn analogue(name: &'static str, address: u64, pin: u32, fails: &'static str) -> Demand {
    demand(name, address, 3 << (2 * pin), 3 << (2 * pin), fails)
}

/// With the chip's own converters: the command read back, a second displacement, the head's acceleration.
pub const OF_ONE: [Demand; 6] = [
    ranks("ADC2_JSQR", [4, 13, 12]),
    sampled(
        "ADC2_SMPR2.SMP4",
        ADC2_SMPR2,
        4,
        "the command read back is not sampled for 56 cycles",
    ),
    sampled(
        "ADC2_SMPR1.SMP13",
        ADC2_SMPR1,
        3,
        "the second displacement is not sampled for 56 cycles",
    ),
    sampled(
        "ADC2_SMPR1.SMP12",
        ADC2_SMPR1,
        2,
        "the head's acceleration is not sampled for 56 cycles",
    ),
    analogue(
        "GPIOC_MODER.PC3",
        GPIOC_MODER,
        3,
        "the second displacement's pin is not analogue",
    ),
    analogue(
        "GPIOC_MODER.PC2",
        GPIOC_MODER,
        2,
        "the head acceleration's pin is not analogue",
    ),
];

/// With external converters for three actuators: their commands read back.
pub const OF_THREE: [Demand; 7] = [
    ranks("ADC2_JSQR", [3, 10, 13]),
    sampled(
        "ADC2_SMPR2.SMP3",
        ADC2_SMPR2,
        3,
        "the first command read back is not sampled for 56 cycles",
    ),
    sampled(
        "ADC2_SMPR1.SMP10",
        ADC2_SMPR1,
        0,
        "the second command read back is not sampled for 56 cycles",
    ),
    sampled(
        "ADC2_SMPR1.SMP13",
        ADC2_SMPR1,
        3,
        "the third command read back is not sampled for 56 cycles",
    ),
    analogue(
        "GPIOA_MODER.PA3",
        GPIOA_MODER,
        3,
        "the pin of the first command read back is not analogue",
    ),
    analogue(
        "GPIOC_MODER.PC0",
        GPIOC_MODER,
        0,
        "the pin of the second command read back is not analogue",
    ),
    analogue(
        "GPIOC_MODER.PC3",
        GPIOC_MODER,
        3,
        "the pin of the third command read back is not analogue",
    ),
];
