//! External converters: an AD7606 on TIM2 and SPI1, an AD5761R or an AD5754R on TIM4 and SPI3.

use super::*;

/// Without these no conversion begins: what makes CONVST's edge.
pub const SAMPLING: [Demand; 7] = [
    demand(
        "TIM2_CCMR2.OC3M",
        TIM2_CCMR2,
        7 << 4,
        6 << 4,
        "CONVST does not rise with the timer's update",
    ),
    demand(
        "TIM2_CCER.CC3E",
        TIM2_CCER,
        1 << 8,
        1 << 8,
        "TIM2 does not drive CONVST",
    ),
    demand(
        "TIM2_CCER.CC3P",
        TIM2_CCER,
        1 << 9,
        0,
        "CONVST falls where it should rise: the sample is 2 us late",
    ),
    demand(
        "TIM2_CCR3",
        TIM2_CCR3,
        0xffff_ffff,
        168,
        "CONVST is not high for 2 us",
    ),
    demand(
        "GPIOB_MODER.PB10",
        GPIOB_MODER,
        3 << 20,
        2 << 20,
        "CONVST is not the timer's",
    ),
    demand(
        "GPIOB_AFRH.PB10",
        GPIOB_AFRH,
        15 << 8,
        1 << 8,
        "another peripheral drives CONVST",
    ),
    PRESCALER,
];

/// Without these the conversions are not read, or not in time.
pub const READING: [Demand; 14] = [
    demand(
        "TIM2_CCMR2.CC4S",
        TIM2_CCMR2,
        3 << 8,
        1 << 8,
        "BUSY is not looked at",
    ),
    demand(
        "TIM2_CCER.CC4E and CC4P",
        TIM2_CCER,
        3 << 12,
        3 << 12,
        "the fall of BUSY is not seen",
    ),
    demand(
        "GPIOB_MODER.PB11",
        GPIOB_MODER,
        3 << 22,
        2 << 22,
        "BUSY does not reach the timer",
    ),
    demand(
        "GPIOB_AFRH.PB11",
        GPIOB_AFRH,
        15 << 12,
        1 << 12,
        "BUSY reaches another peripheral",
    ),
    demand(
        "TIM2_CR2.MMS",
        TIM2_CR2,
        7 << 4,
        2 << 4,
        "the timer's update does not start TIM4",
    ),
    demand(
        "TIM2_DIER.CC1IE",
        TIM2_DIER,
        1 << 1,
        1 << 1,
        "the end of a conversion interrupts nobody",
    ),
    demand(
        "TIM2_CCR1",
        TIM2_CCR1,
        0xffff_ffff,
        504,
        "the step does not begin 6 us after the trigger",
    ),
    demand(
        "SPI1_CR1.CPHA and CPOL",
        SPI1_CR1,
        3,
        2,
        "each bit of the AD7606 is read half a clock off",
    ),
    demand(
        "SPI1_CR1.DFF",
        SPI1_CR1,
        1 << 11,
        1 << 11,
        "a word of the AD7606 has no 16 bits",
    ),
    demand(
        "SPI1_CR1.BR",
        SPI1_CR1,
        7 << 3,
        2 << 3,
        "SPI1 does not run at 10.5 MHz; the AD7606 takes 14.5 at most",
    ),
    demand(
        "GPIOA_MODER.PA5 and PA6",
        GPIOA_MODER,
        15 << 10,
        10 << 10,
        "SPI1's pins are not its own",
    ),
    demand(
        "GPIOA_AFRL.PA5 and PA6",
        GPIOA_AFRL,
        0xff << 20,
        0x55 << 20,
        "another peripheral has SPI1's pins",
    ),
    demand(
        "GPIOD_MODER.PD14",
        GPIOD_MODER,
        3 << 28,
        1 << 28,
        "the AD7606's CS drives nothing",
    ),
    demand(
        "GPIOF_MODER.PF12",
        GPIOF_MODER,
        3 << 24,
        1 << 24,
        "the AD7606's RESET drives nothing",
    ),
];

/// Without these the output never takes a command, or not at its instant.
pub const OUTPUT: [Demand; 15] = [
    FOLLOWS,
    STARTED,
    ONE_PULSE,
    EDGE,
    demand(
        "TIM4_CCR1",
        TIM4_CCR1,
        0xffff,
        5040,
        "the command is not taken over 60 us after the sample",
    ),
    demand(
        "TIM4_CCER.CC1E",
        TIM4_CCER,
        1,
        1,
        "TIM4 does not drive LDAC",
    ),
    demand(
        "TIM4_CCER.CC1P",
        TIM4_CCER,
        2,
        2,
        "LDAC is low all the time: the command is shown when it is written, not at its instant",
    ),
    demand(
        "GPIOD_MODER.PD12",
        GPIOD_MODER,
        3 << 24,
        2 << 24,
        "LDAC is not the timer's",
    ),
    demand(
        "GPIOD_AFRH.PD12",
        GPIOD_AFRH,
        15 << 16,
        2 << 16,
        "another peripheral drives LDAC",
    ),
    demand(
        "GPIOD_MODER.PD2",
        GPIOD_MODER,
        3 << 4,
        1 << 4,
        "SYNC drives nothing",
    ),
    demand(
        "SPI3_CR1.CPHA and CPOL",
        SPI3_CR1,
        3,
        1,
        "the output converter reads each bit half a clock off",
    ),
    demand(
        "SPI3_CR1.DFF",
        SPI3_CR1,
        1 << 11,
        0,
        "a command of the output converter has no 24 bits",
    ),
    demand(
        "SPI3_CR1.BR",
        SPI3_CR1,
        7 << 3,
        1 << 3,
        "SPI3 does not run at 10.5 MHz",
    ),
    demand(
        "GPIOC_MODER.PC10 to PC12",
        GPIOC_MODER,
        63 << 20,
        42 << 20,
        "SPI3's pins are not its own",
    ),
    demand(
        "GPIOC_AFRH.PC10 to PC12",
        GPIOC_AFRH,
        0xfff << 8,
        0x666 << 8,
        "another peripheral has SPI3's pins",
    ),
];

/// The same with three actuators, whose commands take longer to compute and write.
pub const OUTPUT_OF_THREE: [Demand; OUTPUT.len()] = {
    let mut all = OUTPUT;
    let mut i = 0;
    while i < all.len() {
        if all[i].address == TIM4_CCR1 {
            all[i].value = 6720;
            all[i].fails = "the commands are not taken over 80 us after the sample";
        }
        i += 1;
    }
    all
};
