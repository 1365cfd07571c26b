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

    /// The codes of the latest conversions, 0 to 4095; to be asked for at least 10 us after the sample.
    #[inline]
    pub fn codes(&self) -> [u16; INPUTS] {
        core::array::from_fn(|rank| pac::ADC2.jdr(rank).read().jdata())
    }
}
