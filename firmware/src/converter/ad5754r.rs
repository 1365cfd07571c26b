//! The AD5754R: four outputs of -10 to +10 V, 16 bits, with internal reference; three outputs are used.
//!
//! According to its data sheet (Analog Devices) a [command](super::output) has a read/write bit, a zero, three register
//! bits, three output bits and 16 data bits. Codes wait in the input registers for the falling edge of LDAC, which
//! transfers all of them to the outputs at once. After power-up the outputs are clamped to ground until they are
//! powered up one by one; the codes are zero then, which with BIN/2sCOMP at ground (two's complement) is 0 V, the
//! middle of the stroke.

use super::output::OutputBus;
use crate::chip::this::conversion::WAIT;

// Registers, in bits 3 to 5 of the first byte; outputs in 0 to 2.
const READ: u8 = 1 << 7;
const CODE: u8 = 0 << 3;
const RANGE: u8 = 1 << 3;
const POWER: u8 = 2 << 3;
const CONTROL: u8 = 3 << 3;

/// All outputs, in the range register.
const ALL: u8 = 4;

// For the control register.
const NOTHING: u8 = CONTROL;
const MANNER: u8 = CONTROL | 1;
const CLEAR: u8 = CONTROL | 4;

/// -10 to +10 V.
const TEN_VOLTS: u16 = 4;

/// Thermal shutdown, current limit on a short, clear to 0 V.
const GUARDED: u16 = 1 << 3 | 1 << 2;

/// Outputs A to C and the reference are powered.
const POWERED: u16 = 1 << 4 | 7;

/// Bits of the power register that are compared: all written ones, and the flags above them (over-temperature,
/// overcurrent), which must be clear.
const POWER_MASK: u16 = 0x07bf;

/// Converts two's complement to codes that count from the lower end, and back.
const SIGN: u16 = 0x8000;

/// Outputs in use.
pub const OUTPUTS: usize = 3;

/// The converter.
pub struct Ad5754r {
    bus: OutputBus,
    held: bool,
}

impl Ad5754r {
    /// Sets it up, unless it already is and holds its voltages.
    pub fn new(bus: OutputBus) -> Self {
        let mut dac = Self { bus, held: false };
        dac.held = dac.is_set_up();
        if !dac.held {
            for (register, data) in [
                (RANGE | ALL, TEN_VOLTS),
                (MANNER, GUARDED),
                (CLEAR, 0),
                (POWER, POWERED),
            ] {
                dac.bus.command(register, data);
                cortex_m::asm::delay(WAIT);
            }
            // An output accepts codes 10 us after it was powered.
            cortex_m::asm::delay(10 * WAIT);
        }
        dac
    }

    /// True if it was set up when the chip started, and has held its voltages: nothing unknown is ever written.
    pub fn has_held(&self) -> bool {
        self.held
    }

    /// True if it reports the intended setup.
    pub fn is_set_up(&mut self) -> bool {
        let mut read = |register: u8| {
            let answer = self.bus.ask(READ | register, NOTHING);
            answer.map(|bits| bits as u16)
        };
        let powered = read(POWER).map(|p| p & POWER_MASK) == Some(POWERED);
        powered
            && (0..OUTPUTS as u8)
                .all(|output| read(RANGE | output).map(|range| range & 7) == Some(TEN_VOLTS))
    }

    /// Sets the code that an output shows from LDAC's next fall on.
    #[inline]
    pub fn write(&mut self, output: usize, code: u16) {
        self.bus.command(CODE | output as u8, code ^ SIGN);
    }
}
