//! What is recorded beside the control path: three inputs of the chip's second converter, ADC2, converted with the sample at
//! the sampling timer's update.

use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, AnyAdcChannel, Exten, SampleTime};
use embassy_stm32::pac;
use embassy_stm32::peripherals::{ADC1, ADC2};
use embassy_stm32::rcc;
use embassy_stm32::triggers::TIM2_TRGO;

/// Inputs of the converter.
pub const INPUTS: usize = 3;

/// The converter is on, and TIM2's update starts so many injected conversions of it. The three converters of the chip have one
/// reset bit: one that is set up may be reset with the next.
pub(super) fn injected_by_tim2(adc: pac::adc::Adc, conversions: u32) -> bool {
    const ON: u32 = 1;
    // JEXTSEL 3, TIM2_TRGO, and JEXTEN 1, its rising edge.
    const STARTED: u32 = 3 << 16 | 1 << 20;
    const MASK: u32 = ON | 0xf << 16 | 3 << 20;
    let ranks = adc.jsqr().read().0 >> 20 & 3;
    adc.cr2().read().0 & MASK == ON | STARTED && ranks + 1 == conversions
}

/// The converter.
pub struct FurtherAdc(());

impl FurtherAdc {
    /// Ready for TIM2, which does not run yet. The inputs are converted in their order.
    pub fn new(adc: Peri<'static, ADC2>, inputs: [AnyAdcChannel<'static, ADC2>; INPUTS]) -> Self {
        // The registers that the converters share, with the divider of their clock, have ADC1's.
        rcc::enable_and_reset::<ADC1>();
        // As slow as the sensors, so that the same sources settle: 9.7 us for all three, and nobody waits for them.
        let ranks = inputs.map(|input| (input, SampleTime::CYCLES56));
        let injected =
            Adc::new(adc).setup_injected_conversions(ranks, TIM2_TRGO, Exten::RISING_EDGE, false);
        core::mem::forget(injected);
        Self(())
    }

    /// The converter is on, and TIM2's update starts its conversions.
    pub fn is_set_up(&self) -> bool {
        injected_by_tim2(pac::ADC2, INPUTS as u32)
    }

    /// The codes of the latest conversions, 0 to 4095; to be asked for at least 10 us after the sample.
    #[inline]
    pub fn codes(&self) -> [u16; INPUTS] {
        core::array::from_fn(|rank| pac::ADC2.jdr(rank).read().jdata())
    }
}
