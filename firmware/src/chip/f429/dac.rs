//! The chip's own 12-bit output.

use embassy_stm32::gpio::Flex;
use embassy_stm32::peripherals::{DAC1, PA4};
use embassy_stm32::{Peri, pac, rcc};

/// The DAC's trigger number for TIM4.
const DAC_TRIGGER_TIM4: u8 = 5;

/// Channel 1 of the DAC: written codes wait for TIM4.
pub struct DacOutput;

impl DacOutput {
    /// Sets the pin to `code` at once, then hands it to TIM4.
    pub fn new(_dac: Peri<'static, DAC1>, pin: Peri<'static, PA4>, code: u16) -> Self {
        rcc::enable_and_reset::<DAC1>();
        let mut pin = Flex::new(pin);
        pin.set_as_analog();
        core::mem::forget(pin);
        let dac = pac::DAC1;
        let command = Self;
        // An enabled channel outputs its holding register at once until a trigger is set; without a code in it, that
        // would be the end of the stroke.
        command.write(code);
        dac.cr().modify(|w| w.set_tsel(0, DAC_TRIGGER_TIM4));
        dac.cr().modify(|w| w.set_en(0, true));
        command.write(code);
        dac.cr().modify(|w| w.set_ten(0, true));
        command
    }

    /// True if the channel is on and waits for TIM4.
    pub fn is_set_up(&self) -> bool {
        let cr = pac::DAC1.cr().read();
        cr.en(0) && cr.ten(0) && cr.tsel(0) == DAC_TRIGGER_TIM4
    }

    /// The code that the pin outputs from TIM4's next pulse on.
    #[inline]
    pub fn write(&self, code: u16) {
        pac::DAC1.dhr12r(0).write(|w| w.set_dhr(code));
    }
}
