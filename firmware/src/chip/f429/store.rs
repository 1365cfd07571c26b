//! Calibration and test in the second bank of the flash.
//!
//! The chip's flash has two banks: the program runs in the first while the second is written, so the control interrupt
//! is not delayed. Each record has two sectors of its own, see [`Ring`].

use crate::station::{CALIBRATION_BYTES, Flash, Ring, TEST_BYTES, Wiring};
use embassy_stm32::flash::{self, Async, FLASH_BASE};
use link::MAX_ACTUATORS;
use link::command::BoardTest;

/// One per actuator: sectors 12 and 13, 14 and 15, 17 and 18.
const CALIBRATIONS: [Ring<CALIBRATION_BYTES>; MAX_ACTUATORS] = [
    Ring {
        sectors: [0x10_0000, 0x10_4000],
        sector_bytes: 16 * 1024,
        slot_bytes: 64,
    },
    Ring {
        sectors: [0x10_8000, 0x10_c000],
        sector_bytes: 16 * 1024,
        slot_bytes: 64,
    },
    // As few slots as for a test: they are all read at every start.
    Ring {
        sectors: [0x12_0000, 0x14_0000],
        sector_bytes: 128 * 1024,
        slot_bytes: 1024,
    },
];

/// Sectors 22 and 23.
const TESTS: Ring<TEST_BYTES> = Ring {
    sectors: [0x1c_0000, 0x1e_0000],
    sector_bytes: 128 * 1024,
    slot_bytes: 2048,
};
const _: () = assert!(TEST_BYTES <= 2048 && CALIBRATION_BYTES <= 64);

/// Read access to the flash.
pub struct Memory;

impl Memory {
    /// The most recently saved calibration of an actuator, from 0.
    pub fn calibration(&self, actuator: usize) -> Option<Wiring> {
        CALIBRATIONS.get(actuator)?.load(self)
    }

    /// The most recently saved test.
    pub fn test(&self) -> Option<BoardTest> {
        TESTS.load(self)
    }
}

impl Flash for Memory {
    fn read(&self, offset: u32, bytes: &mut [u8]) {
        let begin = (FLASH_BASE as u32 + offset) as *const u8;
        for (i, byte) in bytes.iter_mut().enumerate() {
            // SAFETY: this chip's flash can always be read; volatile because it changes by other means than stores.
            *byte = unsafe { begin.add(i).read_volatile() };
        }
    }

    async fn write(&mut self, _: u32, _: &[u8]) -> bool {
        false
    }

    async fn erase(&mut self, _: u32, _: u32) -> bool {
        false
    }
}

/// Write access to the flash.
pub struct Store(flash::Flash<'static, Async>);

impl Store {
    /// Takes the flash.
    pub fn new(flash: flash::Flash<'static, Async>) -> Self {
        Self(flash)
    }

    /// Writes what is given, one calibration per actuator; returns whether all of it reads back unchanged.
    pub async fn save(&mut self, test: Option<&BoardTest>, wirings: &[Option<Wiring>]) -> bool {
        let mut saved = true;
        for (ring, wiring) in CALIBRATIONS.iter().zip(wirings) {
            if let Some(wiring) = wiring {
                saved &= ring.save(self, wiring).await;
            }
        }
        if let Some(test) = test {
            saved &= TESTS.save(self, test).await;
        }
        saved
    }
}

impl Flash for Store {
    fn read(&self, offset: u32, bytes: &mut [u8]) {
        Memory.read(offset, bytes);
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> bool {
        self.0.write(offset, bytes).await.is_ok()
    }

    async fn erase(&mut self, offset: u32, bytes: u32) -> bool {
        self.0.erase(offset, offset + bytes).await.is_ok()
    }
}
