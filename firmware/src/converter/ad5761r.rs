//! The AD5761R: one output of -10 to +10 V, 16 bits, with internal reference.
//!
//! According to its data sheet (Analog Devices, Rev. C) a [command](super::output) has four don't-care bits, four
//! command bits and 16 data bits. A code waits in the input register for the falling edge of LDAC. After power-up and
//! after a full reset the output is clamped to ground until the control register is written.

use super::output::OutputBus;
use crate::chip::this::conversion::WAIT;

// Commands.
const NOTHING: u8 = 0x0;
const WRITE_INPUT: u8 = 0x1;
const WRITE_CONTROL: u8 = 0x4;
const READ_CONTROL: u8 = 0xc;
const FULL_RESET: u8 = 0xf;

/// Clear voltage and power-up voltage at mid-scale, thermal shutdown, internal reference, range -10 to +10 V, straight
/// binary.
const CONTROL: u16 = 1 << 9 | 1 << 6 | 1 << 5 | 1 << 3;

/// Bits of the control register that are compared: all written ones, and the brown-out flag above, which must be clear.
const CONTROL_MASK: u32 = 0xfff;

/// The converter.
pub struct Ad5761r {
    bus: OutputBus,
    held: bool,
}

impl Ad5761r {
    /// Sets it up, unless it already is and holds its voltage.
    pub fn new(bus: OutputBus) -> Self {
        let mut dac = Self { bus, held: false };
        dac.held = dac.is_set_up();
        if !dac.held {
            dac.bus.command(FULL_RESET, 0);
            cortex_m::asm::delay(WAIT);
            dac.bus.command(WRITE_CONTROL, CONTROL);
            cortex_m::asm::delay(WAIT);
        }
        dac
    }

    /// True if it was set up when the chip started, and has held its voltage: nothing unknown is ever written.
    pub fn has_held(&self) -> bool {
        self.held
    }

    /// True if it reports the intended setup.
    pub fn is_set_up(&mut self) -> bool {
        let answer = self.bus.ask(READ_CONTROL, NOTHING);
        answer.is_some_and(|bits| bits & CONTROL_MASK == u32::from(CONTROL))
    }

    /// Sets the code that the output shows from LDAC's next fall on.
    #[inline]
    pub fn write(&mut self, code: u16) {
        self.bus.command(WRITE_INPUT, code);
    }
}
