//! How the AD5761R and the AD5754R are talked to: 24 bits a command, read at the falling edges of SCLK while SYNC is
//! low, in force when SYNC rises. What a read command asks for comes with the next one.

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
    /// A command; gives what the one before it asked for.
    #[inline]
    pub fn command(&mut self, first: u8, data: u16) -> Option<u32> {
        self.bus.empty();
        self.sync.set_low();
        let [high, low] = data.to_be_bytes();
        let answer = self.bus.exchange_24([first, high, low]);
        self.sync.set_high();
        answer
    }

    /// What the read command `question` gives; `nothing` is a command without effect.
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
