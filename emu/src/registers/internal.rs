//! The chip's own converters: ADC1 triggered by TIM2, the DAC by TIM4.

use super::*;

/// Without these nothing is sampled: what starts the ADC, and what it converts.
pub const SAMPLING: [Demand; 11] = [
    UPDATE_LEAVES,
    PRESCALER,
    demand(
        "ADC1_CR2.JEXTSEL",
        ADC1_CR2,
        15 << 16,
        3 << 16,
        "another timer starts the conversions",
    ),
    demand(
        "ADC1_CR2.JEXTEN",
        ADC1_CR2,
        3 << 20,
        1 << 20,
        "the timer's update starts no conversion",
    ),
    demand("ADC1_CR2.ADON", ADC1_CR2, 1, 1, "the converter is off"),
    demand(
        "ADC1_CR1.SCAN",
        ADC1_CR1,
        1 << 8,
        1 << 8,
        "only the first rank is converted",
    ),
    demand(
        "ADC1_CR1.JEOCIE",
        ADC1_CR1,
        1 << 7,
        1 << 7,
        "the end of the conversions interrupts nobody",
    ),
    demand(
        "ADC1_JSQR",
        ADC1_JSQR,
        0x003f_ffff,
        JSQR,
        "the ranks are not displacement, force, force, displacement",
    ),
    demand(
        "ADC_CCR.ADCPRE",
        ADC_CCR,
        3 << 16,
        1 << 16,
        "the converter's clock is not 21 MHz: too fast, or not done in 13 us",
    ),
    demand(
        "ADC1_SMPR2.SMP3",
        ADC1_SMPR2,
        7 << 9,
        3 << 9,
        "the displacement is not sampled for 56 cycles",
    ),
    demand(
        "ADC1_SMPR1.SMP10",
        ADC1_SMPR1,
        7,
        3,
        "the force is not sampled for 56 cycles",
    ),
];

/// Four ranks: channels 3, 10, 10, 3.
const JSQR: u64 = 3 << 20 | 3 << 15 | 10 << 10 | 10 << 5 | 3;

/// Without these a sensor's reading is wrong.
pub const PINS: [Demand; 2] = [
    demand(
        "GPIOA_MODER.PA3",
        GPIOA_MODER,
        3 << 6,
        3 << 6,
        "the displacement's pin is not analogue",
    ),
    demand(
        "GPIOC_MODER.PC0",
        GPIOC_MODER,
        3,
        3,
        "the force's pin is not analogue",
    ),
];

/// Without these the output never takes a command, or not at its instant.
pub const OUTPUT: [Demand; 11] = [
    FOLLOWS,
    STARTED,
    ONE_PULSE,
    EDGE,
    demand(
        "TIM4_CCR1",
        TIM4_CCR1,
        0xffff,
        3360,
        "the command is not taken over 40 us after the sample",
    ),
    demand(
        "TIM4_CR2.MMS",
        TIM4_CR2,
        7 << 4,
        4 << 4,
        "TIM4's compare does not leave it",
    ),
    demand("DAC_CR.EN1", DAC_CR, 1, 1, "the DAC's pin floats"),
    demand(
        "DAC_CR.BOFF1",
        DAC_CR,
        1 << 1,
        0,
        "the DAC drives no load of 5 kOhm",
    ),
    demand(
        "DAC_CR.TEN1",
        DAC_CR,
        1 << 2,
        1 << 2,
        "the command is shown when it is written, not at its instant",
    ),
    demand(
        "DAC_CR.TSEL1",
        DAC_CR,
        7 << 3,
        5 << 3,
        "another timer hands the command over",
    ),
    demand(
        "GPIOA_MODER.PA4",
        GPIOA_MODER,
        3 << 8,
        3 << 8,
        "the DAC's pin is not analogue",
    ),
];
