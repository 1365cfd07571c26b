//! Data that survive power-off: calibration and test, each a separate record with its own version.
//!
//! A calibration belongs to the wiring. It outlives the test, and new versions of the link: its bytes are defined here,
//! not by serde. A test belongs to the link version that it came with; under any other it is ignored.
//!
//! | bytes | what |
//! |---|---|
//! | 0..3 | kind of record |
//! | 3 | version of its body |
//! | 4..8 | sequence number: the largest counts |
//! | 8..10 | bytes of the body |
//! | 10.. | body, then CRC-32 of everything before |
//! | last 4 | of a calibration: zero once everything before has been read back, see [`FlashRecord::MARKED`] |

use link::channel::Calibration;
use link::command::BoardTest;
use link::frame::{MAX_BODY, checksum};
use link::{CodeRange, VERSION};

const HEAD: usize = 10;
/// Kind, version and sequence number.
pub(super) const NUMBERED: usize = 8;
const TAIL: usize = 4;
/// Bytes at the end of a slot that mark it as whole.
pub(super) const MARK: usize = 4;

/// Bytes of a slot for a test: head, body, check sum, rounded up to whole words.
pub const TEST_BYTES: usize = (HEAD + MAX_BODY + TAIL).next_multiple_of(4);

/// Bytes of a slot for a calibration.
pub const CALIBRATION_BYTES: usize = 64;

/// Data that can be kept in a slot of `BYTES`.
pub trait FlashRecord<const BYTES: usize>: Sized {
    /// Kind of record, and the version of its body.
    const KIND: [u8; 4];

    /// The last word of a slot is written after all others, once they have been read back: a record with that word but
    /// a wrong sum was whole once, and is no saving cut short by a power failure.
    const MARKED: bool;

    /// Writes the body; returns its length.
    fn body(&self, room: &mut [u8]) -> Option<usize>;

    /// Decodes the body.
    fn from_body(body: &[u8]) -> Option<Self>;

    /// Encodes it as a slot, followed by erased flash's 0xff; `None` if it does not fit.
    fn encode(&self, sequence: u32) -> Option<[u8; BYTES]> {
        let mut slot = [0xff; BYTES];
        let mark = if Self::MARKED { MARK } else { 0 };
        let length = self.body(slot.get_mut(HEAD..BYTES - TAIL - mark)?)?;
        let end = HEAD + length;
        slot.get_mut(..4)?.copy_from_slice(&Self::KIND);
        slot.get_mut(4..8)?.copy_from_slice(&sequence.to_le_bytes());
        let length = u16::try_from(length).ok()?;
        slot.get_mut(8..HEAD)?
            .copy_from_slice(&length.to_le_bytes());
        let sum = checksum(slot.get(..end)?.iter().copied());
        slot.get_mut(end..end + TAIL)?
            .copy_from_slice(&sum.to_le_bytes());
        Some(slot)
    }

    /// The sequence number in a slot's first bytes, at least [`NUMBERED`] of them; `None` if it is no such record.
    fn sequence(slot: &[u8]) -> Option<u32> {
        let (kind, rest) = slot.split_first_chunk::<4>()?;
        let sequence = u32::from_le_bytes(*rest.first_chunk()?);
        (*kind == Self::KIND).then_some(sequence)
    }

    /// Decodes a slot, with its sequence number; `None` if it is empty, damaged, or of another version.
    fn decode(slot: &[u8]) -> Option<(u32, Self)> {
        let sequence = Self::sequence(slot)?;
        let (_, rest) = slot.split_at_checked(NUMBERED)?;
        let length = usize::from(u16::from_le_bytes(*rest.first_chunk()?));
        let body = rest.get(2..2 + length)?;
        let sum = u32::from_le_bytes(*rest.get(2 + length..)?.first_chunk()?);
        if checksum(slot.get(..HEAD + length)?.iter().copied()) != sum {
            return None;
        }
        Some((sequence, Self::from_body(body)?))
    }
}

impl FlashRecord<TEST_BYTES> for BoardTest {
    const KIND: [u8; 4] = [b'O', b'L', b'T', VERSION];
    const MARKED: bool = false;

    fn body(&self, room: &mut [u8]) -> Option<usize> {
        Some(postcard::to_slice(self, room).ok()?.len())
    }

    fn from_body(body: &[u8]) -> Option<Self> {
        match postcard::take_from_bytes(body) {
            Ok((test, [])) => Some(test),
            _ => None,
        }
    }
}

/// The origin of a calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Made {
    /// The board uses its placeholder.
    ByNobody,
    /// It was sent, or saved earlier.
    BySomebody,
    /// The placeholder was sent instead: what was saved earlier must not return.
    TakenBack,
}

/// A calibration and the board to which it belongs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wiring {
    /// The lines.
    pub calibration: Calibration,
    /// The highest codes of sensors and command: a calibration of other converters is invalid.
    pub tops: [u16; 2],
    /// The image's number of actuators: a calibration for another number belongs to another rig.
    pub actuators: u8,
}

impl Wiring {
    /// A calibration for converters with `codes` and `actuators` actuators.
    pub const fn new(calibration: Calibration, codes: &CodeRange, actuators: usize) -> Self {
        Self {
            calibration,
            tops: [codes.sensor_top, codes.command_top],
            actuators: actuators as u8,
        }
    }

    /// The calibration, if it fits converters with `codes` and so many `actuators`, is valid, and is not the
    /// placeholder of an uncalibrated board, which a test on the desk, or a withdrawn calibration, may have left.
    pub fn of(&self, codes: &CodeRange, actuators: usize) -> Option<Calibration> {
        let fits = *self == Self::new(self.calibration, codes, actuators);
        let means = self.calibration.is_made(codes) && self.calibration.check(codes).is_ok();
        (fits && means).then_some(self.calibration)
    }
}

impl FlashRecord<CALIBRATION_BYTES> for Wiring {
    // Version 1 lacked the number of actuators.
    const KIND: [u8; 4] = [b'O', b'L', b'C', 2];
    const MARKED: bool = true;

    fn body(&self, room: &mut [u8]) -> Option<usize> {
        let (board, rest) = room.split_first_chunk_mut::<5>()?;
        let [sensor, command] = self.tops.map(u16::to_le_bytes);
        *board = [sensor[0], sensor[1], command[0], command[1], self.actuators];
        let lines = self.calibration.to_bytes();
        rest.get_mut(..lines.len())?.copy_from_slice(&lines);
        Some(board.len() + lines.len())
    }

    fn from_body(body: &[u8]) -> Option<Self> {
        let (&[s0, s1, c0, c1, actuators], lines) = body.split_first_chunk::<5>()?;
        Some(Self {
            calibration: Calibration::from_bytes(lines.try_into().ok()?),
            tops: [u16::from_le_bytes([s0, s1]), u16::from_le_bytes([c0, c1])],
            actuators,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::CODES;
    use outerloop_core::Config;

    fn test() -> BoardTest {
        let mut config = Config::shear_frame([1000.0; 3], [158e3; 3], [0.02; 3]);
        config.structure.physical_storeys = Some(1);
        config.into()
    }

    fn wiring() -> Wiring {
        Wiring::new(Calibration::placeholder(&CODES), &CODES, 1)
    }

    fn comes_back<const BYTES: usize, T: FlashRecord<BYTES> + PartialEq + core::fmt::Debug>(
        kept: T,
    ) {
        let slot = kept.encode(7).unwrap();
        assert_eq!(T::decode(&slot), Some((7, kept)));
        let end = slot.iter().rposition(|&b| b != 0xff).unwrap() + 1;
        for bit in 0..end * 8 {
            let mut bad = slot;
            bad[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(T::decode(&bad), None, "bit {bit}");
        }
        assert_eq!(T::decode(&[0xff; BYTES]), None);
        assert_eq!(T::decode(&[]), None);
    }

    #[test]
    fn both_come_back_as_they_were_and_not_when_a_bit_has_turned() {
        comes_back(test());
        comes_back(wiring());
    }

    #[test]
    fn a_calibration_is_kept_in_bytes_that_do_not_change_with_the_link() {
        let slot = wiring().encode(1).unwrap();
        // Contains no version of the link; every later firmware reads what a board has in its flash.
        assert_eq!(
            slot[..15],
            [
                b'O', b'L', b'C', 2, 1, 0, 0, 0, 30, 0, 0xfe, 0x1f, 0xff, 0x0f, 1
            ]
        );
    }

    #[test]
    fn a_calibration_of_other_converters_or_of_another_number_of_actuators_is_none() {
        let sixteen = CodeRange {
            sensor_top: 65_535,
            command_top: 65_535,
            ..CODES
        };
        let made = Wiring::new(Calibration::over(0.1, 1e4, &CODES), &CODES, 1);
        assert_eq!(made.of(&CODES, 1), Some(made.calibration));
        assert_eq!(made.of(&sixteen, 1), None);
        assert_eq!(made.of(&CODES, 3), None);
    }

    #[test]
    fn what_a_board_goes_by_that_nobody_has_calibrated_is_no_calibration() {
        assert_eq!(wiring().of(&CODES, 1), None);
    }
}
