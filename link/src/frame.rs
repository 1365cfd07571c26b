//! Frames: `COBS( version | kind | sequence number | body | CRC-32 ) 0`, little-endian.
//!
//! A zero byte occurs only at the end of a frame, so a receiver that joins late, or has lost bytes, resynchronises at
//! the next one.
//!
//! ```
//! use link::{Decoder, Frame, FrameKind};
//!
//! let frame = Frame { kind: FrameKind::Telemetry, sequence: 7, body: &[1, 0, 2] };
//! let wire = frame.encode().expect("short enough");
//! let mut decoder = Decoder::new();
//! // Noise, and the rest of a frame that began before anybody listened.
//! for byte in [0x55, 0x13, 0] {
//!     assert_eq!(decoder.push(byte), None);
//! }
//! let mut came = 0;
//! for byte in wire {
//!     came += usize::from(decoder.push(byte).is_some_and(|arrived| arrived == frame));
//! }
//! assert_eq!(came, 1);
//! ```

use crate::agreed::VERSION;
use crc::{CRC_32_ISO_HDLC, Crc, Table};
use heapless::Vec;

/// The longest body: a test of two coupled actuators, with every number written out. A board keeps it in a slot of its flash
/// of 2 KiB.
pub const MAX_BODY: usize = 1080;

/// Version, kind and sequence number before the body.
const HEAD: usize = 4;

/// The check sum after the body.
const TAIL: usize = 4;

/// Bytes that a body of `body` bytes takes on the wire, at most.
pub const fn wire_bytes(body: usize) -> usize {
    let plain = HEAD + body + TAIL;
    // One byte of COBS for every 254 begun, and the zero.
    plain + plain / 254 + 2
}

/// The longest frame on the wire.
pub const MAX_WIRE: usize = wire_bytes(MAX_BODY);

static CRC: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// The check sum of frames and of a whole ground motion: CRC-32/ISO-HDLC.
pub fn checksum(bytes: impl IntoIterator<Item = u8>) -> u32 {
    let mut digest = CRC.digest();
    for byte in bytes {
        digest.update(&[byte]);
    }
    digest.finalize()
}

/// The content of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum FrameKind {
    /// PC to board: a [`Command`](crate::Command).
    Command = 1,
    /// Board to PC: a [`Reply`](crate::Reply).
    Reply = 2,
    /// Board to PC: [`Telemetry`](crate::Telemetry).
    Telemetry = 3,
}

impl FrameKind {
    const ALL: [Self; 3] = [Self::Command, Self::Reply, Self::Telemetry];
}

/// A complete frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame<'a> {
    /// The kind of body.
    pub kind: FrameKind,
    /// The sender's number; a reply carries the number of the command that it answers in its body.
    pub sequence: u16,
    /// The body.
    pub body: &'a [u8],
}

/// A body is longer than [`MAX_BODY`], or the buffer is too small for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong;

impl Frame<'_> {
    /// The bytes on the wire, including the closing zero.
    ///
    /// # Errors
    /// The body is longer than [`MAX_BODY`].
    pub fn encode(&self) -> Result<Vec<u8, MAX_WIRE>, TooLong> {
        let mut plain = Vec::<u8, { HEAD + MAX_BODY + TAIL }>::new();
        let [low, high] = self.sequence.to_le_bytes();
        let fits = plain
            .extend_from_slice(&[VERSION, self.kind as u8, low, high])
            .and_then(|()| plain.extend_from_slice(self.body));
        fits.map_err(|_| TooLong)?;
        let sum = CRC.checksum(&plain).to_le_bytes();
        plain.extend_from_slice(&sum).map_err(|_| TooLong)?;

        let mut wire = Vec::new();
        wire.resize_default(MAX_WIRE).map_err(|_| TooLong)?;
        let coded = cobs::try_encode(&plain, &mut wire).map_err(|_| TooLong)?;
        wire.truncate(coded);
        wire.push(0).map_err(|_| TooLong)?;
        Ok(wire)
    }
}

/// What a [`Decoder`] has seen since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct DecoderCounts {
    /// Good frames.
    pub good: u32,
    /// Frames that were not coded as a frame, were too short or of an unknown kind.
    pub malformed: u32,
    /// Frames whose check sum did not fit.
    pub corrupt: u32,
    /// Runs of bytes longer than any frame.
    pub too_long: u32,
    /// Good frames of another version.
    pub other_version: u32,
}

impl DecoderCounts {
    /// Everything that was not a good frame.
    pub const fn bad(&self) -> u32 {
        self.malformed
            .wrapping_add(self.corrupt)
            .wrapping_add(self.too_long)
            .wrapping_add(self.other_version)
    }
}

/// Turns incoming bytes into frames. Its memory is one frame; its work per byte is bounded by one frame.
#[derive(Clone, Debug)]
pub struct Decoder {
    wire: [u8; MAX_WIRE],
    /// Bytes since the last zero; more than fit means the frame is lost.
    length: usize,
    seen: DecoderCounts,
    other_version: Option<u8>,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

/// Why the bytes between two zeros are not a frame of this version.
enum Bad {
    Malformed,
    Corrupt,
    OtherVersion(u8),
}

impl Decoder {
    /// Has seen nothing.
    pub const fn new() -> Self {
        Self {
            wire: [0; MAX_WIRE],
            length: 0,
            seen: DecoderCounts {
                good: 0,
                malformed: 0,
                corrupt: 0,
                too_long: 0,
                other_version: 0,
            },
            other_version: None,
        }
    }

    /// Takes a byte; returns a frame at the byte that closes a good one. Two zeros in a row are ignored: a sender may
    /// put a zero before a frame to end whatever came before it.
    pub fn push(&mut self, byte: u8) -> Option<Frame<'_>> {
        if byte != 0 {
            if let Some(place) = self.wire.get_mut(self.length) {
                *place = byte;
            }
            self.length = self.length.saturating_add(1);
            return None;
        }
        let coded = match core::mem::take(&mut self.length) {
            0 => return None,
            length => self.wire.get_mut(..length),
        };
        let Some(coded) = coded else {
            self.seen.too_long = self.seen.too_long.wrapping_add(1);
            return None;
        };
        match open(coded) {
            Ok(frame) => {
                self.seen.good = self.seen.good.wrapping_add(1);
                return Some(frame);
            }
            Err(Bad::Malformed) => self.seen.malformed = self.seen.malformed.wrapping_add(1),
            Err(Bad::Corrupt) => self.seen.corrupt = self.seen.corrupt.wrapping_add(1),
            Err(Bad::OtherVersion(version)) => {
                self.seen.other_version = self.seen.other_version.wrapping_add(1);
                self.other_version = Some(version);
            }
        }
        None
    }

    /// The counts so far.
    pub const fn seen(&self) -> DecoderCounts {
        self.seen
    }

    /// The version of the last good frame of another version, if one came.
    pub const fn other_version(&self) -> Option<u8> {
        self.other_version
    }
}

/// Decodes the bytes between two zeros, in place.
fn open(coded: &mut [u8]) -> Result<Frame<'_>, Bad> {
    let length = cobs::decode_in_place(coded).map_err(|_| Bad::Malformed)?;
    let plain = coded.get(..length).ok_or(Bad::Malformed)?;
    let (inner, sum) = plain.split_last_chunk::<TAIL>().ok_or(Bad::Malformed)?;
    let (head, body) = inner.split_first_chunk::<HEAD>().ok_or(Bad::Malformed)?;
    if CRC.checksum(inner) != u32::from_le_bytes(*sum) {
        return Err(Bad::Corrupt);
    }
    let [version, kind, low, high] = *head;
    if version != VERSION {
        return Err(Bad::OtherVersion(version));
    }
    let kind = FrameKind::ALL.into_iter().find(|&k| k as u8 == kind);
    Ok(Frame {
        kind: kind.ok_or(Bad::Malformed)?,
        sequence: u16::from_le_bytes([low, high]),
        body,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec as List;

    fn decode_all(decoder: &mut Decoder, bytes: &[u8]) -> List<(FrameKind, u16, List<u8>)> {
        let mut frames = List::new();
        for &byte in bytes {
            if let Some(f) = decoder.push(byte) {
                frames.push((f.kind, f.sequence, f.body.to_vec()));
            }
        }
        frames
    }

    fn frame(sequence: u16, body: &[u8]) -> List<u8> {
        let frame = Frame {
            kind: FrameKind::Command,
            sequence,
            body,
        };
        frame.encode().unwrap().to_vec()
    }

    #[test]
    fn a_body_too_long_is_refused_and_the_longest_is_not() {
        let body = [0xff; MAX_BODY + 1];
        let longest = frame(7, &body[..MAX_BODY]);
        assert_eq!(longest.len(), MAX_WIRE);
        assert_eq!(decode_all(&mut Decoder::new(), &longest).len(), 1);
        let over = Frame {
            kind: FrameKind::Reply,
            sequence: 0,
            body: &body,
        };
        assert_eq!(over.encode(), Err(TooLong));
    }

    #[test]
    fn another_version_is_told_apart_from_noise() {
        let mut plain = std::vec![VERSION + 1, 1, 0, 0, 42];
        plain.extend(CRC.checksum(&plain).to_le_bytes());
        let mut wire = [0; 32];
        cobs::encode(&plain, &mut wire);
        let mut decoder = Decoder::new();
        assert!(decode_all(&mut decoder, &wire).is_empty());
        assert_eq!(decoder.other_version(), Some(VERSION + 1));
        assert_eq!(decoder.seen().other_version, 1);
    }

    #[test]
    fn after_a_run_of_bytes_longer_than_any_frame_the_next_frame_is_read() {
        let mut decoder = Decoder::new();
        let mut wire = std::vec![0x55; 3 * MAX_WIRE];
        wire.push(0);
        wire.extend(frame(1, b"after"));
        assert_eq!(decode_all(&mut decoder, &wire).len(), 1);
        assert_eq!(decoder.seen().too_long, 1);
    }

    /// More than a million frames of garbage, each followed by a good one: none of the garbage is taken for a frame
    /// and no good frame is missed. Seeded, so it repeats.
    #[test]
    fn a_million_frames_of_garbage_do_no_harm() {
        let mut state = 0x2545_f491_4f6c_dd1d_u64;
        let mut random = move || {
            // xorshift64*
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 32
        };
        let mut decoder = Decoder::new();
        let mut good = 0_u32;
        let mut garbage = 0_u32;
        for round in 0..1_000_000_u32 {
            let body = &round.to_le_bytes();
            let clean = frame(round as u16, body);
            let mut bytes: List<u8> = match round % 4 {
                // Noise, short and, once in a while, longer than any frame.
                0 => {
                    let length = if round % 1000 == 0 {
                        1500
                    } else {
                        random() % 40 + 1
                    };
                    (0..length).map(|_| random() as u8 | 1).collect()
                }
                // A frame with bits turned.
                1 => {
                    let mut bytes = clean.clone();
                    let place = random() as usize % (bytes.len() - 1);
                    bytes[place] ^= (random() % 255 + 1) as u8;
                    bytes
                }
                // A frame cut off.
                2 => clean[..random() as usize % (clean.len() - 2) + 1].to_vec(),
                // A frame with bytes lost from its middle.
                _ => {
                    let mut bytes = clean.clone();
                    let place = random() as usize % (bytes.len() - 2);
                    bytes.remove(place);
                    bytes
                }
            };
            bytes.push(0);
            garbage += 1;
            for &byte in &bytes {
                assert!(decoder.push(byte).is_none(), "round {round}: {bytes:?}");
            }
            for &byte in &clean {
                if let Some(f) = decoder.push(byte) {
                    assert_eq!((f.sequence, f.body), (round as u16, body.as_slice()));
                    good += 1;
                }
            }
        }
        assert_eq!((good, garbage), (1_000_000, 1_000_000));
        let seen = decoder.seen();
        assert_eq!(seen.good, good);
        assert!(seen.bad() >= 1_000_000 && seen.too_long >= 1000 && seen.corrupt > 0);
    }

    proptest! {
        #[test]
        fn comes_back_as_it_was(body in proptest::collection::vec(any::<u8>(), 0..=MAX_BODY), sequence: u16) {
            let wire = frame(sequence, &body);
            prop_assert!(wire[..wire.len() - 1].iter().all(|&b| b != 0));
            prop_assert!(wire.len() <= wire_bytes(body.len()));
            let frames = decode_all(&mut Decoder::new(), &wire);
            prop_assert_eq!(frames, std::vec![(FrameKind::Command, sequence, body)]);
        }

        #[test]
        fn no_stream_of_bytes_is_too_much(bytes in proptest::collection::vec(any::<u8>(), 0..5000)) {
            let mut decoder = Decoder::new();
            decode_all(&mut decoder, &bytes);
            let mut tail = std::vec![0];
            tail.extend(frame(9, b"still here"));
            prop_assert_eq!(decode_all(&mut decoder, &tail).len(), 1);
        }
    }
}
