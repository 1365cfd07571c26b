//! How the AD5761R and the AD5754R are talked to: 24 bits a command on SPI3, read at the falling edges of SCLK while SYNC is
//! low, in force when SYNC rises. What a read command asks for comes with the next one.

use super::bus::{ASKING, Bus, WRITING};
use super::timers::{LoadPin, WAIT};
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::{PC10, PC11, PC12, PD2, PD12, SPI3};

/// The bus of an output converter.
pub struct OutputBus {
    bus: Bus,
    sync: Output<'static>,
}

impl OutputBus {
    /// Ready, with the line that loads what waits. `wires` are SCLK, SDO and SDI.
    pub fn new(
        spi: Peri<'static, SPI3>,
        wires: (
            Peri<'static, PC10>,
            Peri<'static, PC11>,
            Peri<'static, PC12>,
        ),
        sync: Peri<'static, PD2>,
        load: Peri<'static, PD12>,
    ) -> (Self, LoadPin) {
        // What is pulled up outside is high before the bus moves.
        let sync = Output::new(sync, Level::High, Speed::VeryHigh);
        let load = LoadPin::new(load);
        let bus = Bus::of_output(spi, wires.0, wires.1, wires.2);
        (Self { bus, sync }, load)
    }

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
