//! The protocol of the AD5761R and the AD5754R: 24 bits per command, sampled at the falling edges of SCLK while SYNC is
//! low, in effect when SYNC rises. The reply to a read command comes with the next one.

use crate::chip::this::conversion::WAIT;
use crate::chip::this::spi::{ASKING, Bus, WRITING};
use embassy_stm32::gpio::Output;

/// The bus of an output converter.
pub struct OutputBus {
    /// Ready.
    pub bus: Bus,
    /// SYNC, high.
    pub sync: Output<'static>,
}

impl OutputBus {
    /// Sends a command; returns the reply to the previous one.
    #[inline]
    pub fn command(&mut self, first: u8, data: u16) -> Option<u32> {
        self.bus.empty();
        self.sync.set_low();
        let [high, low] = data.to_be_bytes();
        let answer = self.bus.exchange_24([first, high, low]);
        self.sync.set_high();
        answer
    }

    /// The reply to the read command `question`; `nothing` is a command without effect.
    pub fn ask(&mut self, question: u8, nothing: u8) -> Option<u32> {
        self.bus.set_divider(ASKING);
        self.command(question, 0);
        cortex_m::asm::delay(WAIT);
        let answer = self.command(nothing, 0);
        cortex_m::asm::delay(WAIT);
        self.bus.set_divider(WRITING);
        answer
    }
}
