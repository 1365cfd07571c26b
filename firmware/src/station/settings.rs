//! What survives power-off: test and calibration, with a check sum.

use link::VERSION;
use link::channel::Calibration;
use link::frame::{MAX_BODY, checksum};
use outerloop_core::Config;
use serde::{Deserialize, Serialize};

/// Bytes that settings take at most: head, body, check sum.
pub const SETTINGS_BYTES: usize = 8 + MAX_BODY + 4;

const MAGIC: [u8; 4] = *b"OLS\0";

/// What survives power-off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// The test.
    pub config: Config,
    /// The channels' lines.
    pub calibration: Calibration,
}

impl Settings {
    /// As bytes, written to the beginning of `room`; all of `room` behind them is erased flash's 0xff.
    ///
    /// Returns how many bytes count, or `None` if they do not fit.
    pub fn encode(&self, room: &mut [u8; SETTINGS_BYTES]) -> Option<usize> {
        room.fill(0xff);
        let body = room.get_mut(8..SETTINGS_BYTES - 4)?;
        let length = postcard::to_slice(self, body).ok()?.len();
        let length_bytes = u16::try_from(length).ok()?.to_le_bytes();
        let head = [
            MAGIC[0],
            MAGIC[1],
            MAGIC[2],
            VERSION,
            length_bytes[0],
            length_bytes[1],
            0,
            0,
        ];
        room.get_mut(..8)?.copy_from_slice(&head);
        let end = 8 + length;
        let sum = checksum(room.get(..end)?.iter().copied());
        room.get_mut(end..end + 4)?
            .copy_from_slice(&sum.to_le_bytes());
        Some(end + 4)
    }

    /// From bytes; `None` if they are empty, damaged or of another version.
    pub fn decode(bytes: &[u8]) -> Option<Self> {
        let head: &[u8; 8] = bytes.first_chunk()?;
        let [m0, m1, m2, version, low, high, ..] = *head;
        if [m0, m1, m2] != [MAGIC[0], MAGIC[1], MAGIC[2]] || version != VERSION {
            return None;
        }
        let end = 8 + usize::from(u16::from_le_bytes([low, high]));
        let sum = u32::from_le_bytes(*bytes.get(end..)?.first_chunk()?);
        if checksum(bytes.get(..end)?.iter().copied()) != sum {
            return None;
        }
        match postcard::take_from_bytes(bytes.get(8..end)?) {
            Ok((settings, [])) => Some(settings),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings() -> Settings {
        let mut config = Config::shear_frame([1000.0; 3], [158e3; 3], [0.02; 3]);
        config.structure.physical_storeys = Some(1);
        Settings {
            config,
            calibration: Calibration::UNCALIBRATED,
        }
    }

    #[test]
    fn come_back_as_they_were_and_not_when_a_bit_has_turned() {
        let mut room = [0; SETTINGS_BYTES];
        let length = settings().encode(&mut room).unwrap();
        assert_eq!(Settings::decode(&room), Some(settings()));
        for bit in 0..length * 8 {
            let mut bad = room;
            bad[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Settings::decode(&bad), None, "bit {bit}");
        }
        assert_eq!(Settings::decode(&[0xff; SETTINGS_BYTES]), None);
        assert_eq!(Settings::decode(&[]), None);
    }
}
