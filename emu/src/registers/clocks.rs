//! Effect of the chip's clock and reset lines on the registers of its peripherals: without its clock a peripheral ignores
//! writes, and its reset line restores its reset state. RM0090 section 6.3.

use std::ops::Range;

/// RCC's reset registers; the enable register of each is [`TO_ENABLE`] after it.
const AHB1RSTR: u64 = 0x4002_3810;
const APB1RSTR: u64 = 0x4002_3820;
const APB2RSTR: u64 = 0x4002_3824;
const TO_ENABLE: u64 = 0x20;

/// A reset line: the reset register, the reset bit, the enable bits (one is enough for a clock), and the peripheral's
/// addresses.
type Line = (u64, u64, u64, Range<u64>);

/// Lines of the peripherals whose registers are kept. The three ADCs share one reset and have a clock each; ADC3 is not used.
const LINES: [Line; 13] = [
    (AHB1RSTR, 1, 1, 0x4002_0000..0x4002_0400),
    (AHB1RSTR, 1 << 1, 1 << 1, 0x4002_0400..0x4002_0800),
    (AHB1RSTR, 1 << 2, 1 << 2, 0x4002_0800..0x4002_0c00),
    (AHB1RSTR, 1 << 3, 1 << 3, 0x4002_0c00..0x4002_1000),
    (AHB1RSTR, 1 << 4, 1 << 4, 0x4002_1000..0x4002_1400),
    (AHB1RSTR, 1 << 5, 1 << 5, 0x4002_1400..0x4002_1800),
    (APB1RSTR, 1, 1, 0x4000_0000..0x4000_0400),
    (APB1RSTR, 1 << 2, 1 << 2, 0x4000_0800..0x4000_0c00),
    (APB1RSTR, 1 << 15, 1 << 15, 0x4000_3c00..0x4000_4000),
    (APB1RSTR, 1 << 28, 1 << 28, 0x4000_7000..0x4000_7400),
    (APB1RSTR, 1 << 29, 1 << 29, 0x4000_7400..0x4000_7800),
    (APB2RSTR, 1 << 8, 3 << 8, 0x4001_2000..0x4001_2400),
    (APB2RSTR, 1 << 12, 1 << 12, 0x4001_3000..0x4001_3400),
];

/// The reset line of a peripheral without which a board does not sample or output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResetLine {
    /// All of the chip's converters.
    Adc,
    /// The chip's DAC.
    Dac,
    /// SPI1, from the external input converter.
    InputBus,
    /// SPI3, to the external output converter.
    OutputBus,
    /// TIM2.
    SamplingTimer,
    /// TIM4.
    OutputTimer,
}

impl ResetLine {
    /// Its reset register, and its bit.
    pub(crate) const fn place(self) -> (u64, u32) {
        match self {
            Self::Adc => (APB2RSTR, 8),
            Self::Dac => (APB1RSTR, 29),
            Self::InputBus => (APB2RSTR, 12),
            Self::OutputBus => (APB1RSTR, 15),
            Self::SamplingTimer => (APB1RSTR, 0),
            Self::OutputTimer => (APB1RSTR, 2),
        }
    }
}

/// Whether the address is a clock enable register.
pub(super) fn is_enable(address: u64) -> bool {
    let resets = [AHB1RSTR, APB1RSTR, APB2RSTR];
    resets.iter().any(|reset| reset + TO_ENABLE == address)
}

/// Addresses of the peripherals that a write resets.
pub(super) fn put_back(address: u64, value: u64) -> impl Iterator<Item = Range<u64>> {
    let hit = move |line: &&Line| line.0 == address && value & line.1 != 0;
    LINES.iter().filter(hit).map(|line| line.3.clone())
}

/// Whether the peripheral at `address` accepts a write; `read` gives its enable register.
pub(super) fn is_clocked(address: u64, read: impl Fn(u64) -> u64) -> bool {
    let line = LINES.iter().find(|line| line.3.contains(&address));
    line.is_none_or(|(reset, _, clocks, _)| read(reset + TO_ENABLE) & clocks != 0)
}

#[cfg(test)]
mod tests {
    use super::APB2RSTR;
    use crate::registers::{ADC1_CR2, ADC2_CR2, EXTI_IMR, GPIOE_MODER, Registers, TIM2_ARR};
    use crate::registers::{RCC_AHB1ENR, RCC_APB1ENR, RCC_APB2ENR};

    #[test]
    fn a_peripheral_without_its_clock_takes_no_write() {
        for (address, enable, clock) in [
            (TIM2_ARR, RCC_APB1ENR, 1),
            (ADC1_CR2, RCC_APB2ENR, 1 << 8),
            (GPIOE_MODER, RCC_AHB1ENR, 1 << 4),
        ] {
            let mut registers = Registers::default();
            registers.write(address, 7);
            assert_eq!(registers.read(address), 0, "{address:x}");
            registers.write(enable, clock);
            registers.write(address, 7);
            assert_eq!(registers.read(address), 7, "{address:x}");
            registers.write(enable, 0);
            registers.write(address, 9);
            assert_eq!(registers.read(address), 7, "{address:x}");
        }
        // The external interrupts have no clock of their own.
        let mut registers = Registers::default();
        registers.write(EXTI_IMR, 1);
        assert_eq!(registers.read(EXTI_IMR), 1);
    }

    #[test]
    fn the_one_reset_of_the_converters_puts_all_of_them_back_and_nothing_else() {
        let mut registers = Registers::default();
        registers.write(RCC_APB2ENR, 3 << 8);
        registers.write(RCC_APB1ENR, 1);
        for address in [ADC1_CR2, ADC2_CR2, TIM2_ARR] {
            registers.write(address, 5);
        }
        registers.write(APB2RSTR, 1 << 8);
        let held = [ADC1_CR2, ADC2_CR2, TIM2_ARR].map(|address| registers.read(address));
        assert_eq!(held, [0, 0, 5]);
    }
}
