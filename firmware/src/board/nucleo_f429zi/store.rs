//! Test and calibration in the last sector of the flash.
//!
//! The chip's flash has two banks: the program runs in the first while the second is written, so the control interrupt is
//! not held up. The sector is a row of slots; each saving takes the next, and the last good one counts, so power that
//! fails during a saving costs no more than that saving. Only when all 128 slots are used is the sector erased, some 2 s in
//! which losing power loses the settings; the board then starts unconfigured and says so.

use crate::station::{SETTINGS_BYTES, Settings};
use embassy_stm32::flash::{Async, FLASH_BASE, Flash};

/// Beginning of the last sector, from the beginning of the flash.
const SECTOR: u32 = 0x1E_0000;

/// Its length.
const SECTOR_BYTES: u32 = 128 * 1024;

/// Bytes of a slot.
const SLOT: u32 = 1024;
const _: () = assert!(SETTINGS_BYTES <= SLOT as usize && SETTINGS_BYTES.is_multiple_of(4));

/// Writes settings.
pub struct Store(Flash<'static, Async>);

impl Store {
    /// With the flash.
    pub fn new(flash: Flash<'static, Async>) -> Self {
        Self(flash)
    }

    /// Writes `settings` into the next slot; returns whether they read back as they were.
    pub async fn save(&mut self, settings: &Settings) -> bool {
        let mut bytes = [0xff; SETTINGS_BYTES];
        if settings.encode(&mut bytes).is_none() {
            return false;
        }
        let free = slots().find(|&slot| read(slot).iter().all(|&b| b == 0xff));
        let slot = match free {
            Some(slot) => slot,
            None => {
                if self.0.erase(SECTOR, SECTOR + SECTOR_BYTES).await.is_err() {
                    return false;
                }
                SECTOR
            }
        };
        self.0.write(slot, &bytes).await.is_ok() && read(slot) == bytes
    }
}

/// The settings that were saved last.
pub fn load() -> Option<Settings> {
    slots().rev().find_map(|slot| Settings::decode(&read(slot)))
}

fn slots() -> impl DoubleEndedIterator<Item = u32> {
    (SECTOR..SECTOR + SECTOR_BYTES).step_by(SLOT as usize)
}

/// A slot as it is in the flash now.
fn read(slot: u32) -> [u8; SETTINGS_BYTES] {
    let begin = (FLASH_BASE as u32 + slot) as *const u8;
    // SAFETY: flash of this chip, which can always be read; volatile, since it changes by other means than stores.
    core::array::from_fn(|i| unsafe { begin.add(i).read_volatile() })
}
