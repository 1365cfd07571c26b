//! The AD5761R: one output of -10 to +10 V, 16 bits, with a reference of its own.
//!
//! By its data sheet (Analog Devices, Rev. C): 24 bits a command, read at the falling edges of SCLK while SYNC is low, in
//! force when SYNC rises: four bits that mean nothing, four of the command, 16 of data. A code waits in the input register
//! for the falling edge of LDAC. After power-up and after a full reset the output is clamped to ground until the control
//! register is written. What a read command asks for comes with the next one.

use super::bus::Bus;
use super::timers::{Load, WAIT};
use embassy_stm32::Peri;
use embassy_stm32::gpio::{Level, Output, Speed};
use embassy_stm32::peripherals::{PD2, PD12};

// Commands.
const NOTHING: u8 = 0x0;
const WRITE_INPUT: u8 = 0x1;
const WRITE_CONTROL: u8 = 0x4;
const READ_CONTROL: u8 = 0xc;
const FULL_RESET: u8 = 0xf;

/// Clear voltage and power-up voltage in the middle, shut down when too hot, own reference, range -10 to +10 V, straight
/// binary.
const CONTROL: u16 = 1 << 9 | 1 << 6 | 1 << 5 | 1 << 3;

/// What is compared of the control register: all that is written, and the brown-out flag above it, which must be clear.
const CONTROL_MASK: u32 = 0xfff;

/// The converter.
pub struct Dac {
    bus: Bus,
    sync: Output<'static>,
    answered: bool,
}

impl Dac {
    /// Set up, unless it already is and holds its voltage.
    pub fn new(
        bus: impl FnOnce() -> Bus,
        sync: Peri<'static, PD2>,
        load: Peri<'static, PD12>,
    ) -> (Self, Load) {
        // What is pulled up outside is high before the bus moves.
        let sync = Output::new(sync, Level::High, Speed::VeryHigh);
        let load = Load::new(load);
        let bus = bus();
        let mut dac = Self {
            bus,
            sync,
            answered: false,
        };
        if !dac.is_set_up() {
            dac.frame(FULL_RESET, 0);
            cortex_m::asm::delay(WAIT);
            dac.frame(WRITE_CONTROL, CONTROL);
            cortex_m::asm::delay(WAIT);
        }
        dac.answered = dac.is_set_up();
        (dac, load)
    }

    /// It has said that it is set up as it should be.
    pub fn answered(&self) -> bool {
        self.answered
    }

    fn is_set_up(&mut self) -> bool {
        self.frame(READ_CONTROL, 0);
        cortex_m::asm::delay(WAIT);
        let answer = self.frame(NOTHING, 0);
        cortex_m::asm::delay(WAIT);
        answer.is_some_and(|bits| bits & CONTROL_MASK == u32::from(CONTROL))
    }

    /// The code that the output shows from LDAC's next fall on.
    #[inline]
    pub fn write(&mut self, code: u16) {
        self.frame(WRITE_INPUT, code);
    }

    /// A command; gives what the one before it asked for.
    #[inline]
    fn frame(&mut self, command: u8, data: u16) -> Option<u32> {
        self.sync.set_low();
        let [high, low] = data.to_be_bytes();
        let answer = self.bus.exchange_24([command, high, low]);
        self.sync.set_high();
        answer
    }
}
