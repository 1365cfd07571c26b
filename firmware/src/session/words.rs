//! Messages as 32-bit words.

use outerloop_core::Record;
use outerloop_core::config::MAX_DOF;

/// Bytes of the longest message: an output with the record of [`MAX_DOF`] degrees of freedom.
const MAX_BYTES: usize = 4 * (1 + MAX_DOF + Record::<MAX_DOF>::WORDS);

/// A message as it is sent.
pub type Message = heapless::Vec<u8, MAX_BYTES>;

/// A message without meaning.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed;

/// Appends a word; every message fits, since [`MAX_BYTES`] is the length of the longest.
pub(super) fn push(message: &mut Message, word: u32) {
    let fits = message.extend_from_slice(&word.to_le_bytes());
    debug_assert!(fits.is_ok());
}

pub(super) fn push_long(message: &mut Message, long: u64) {
    push(message, long as u32);
    push(message, (long >> 32) as u32);
}

/// The words of a message, in order.
#[derive(Clone, Debug)]
pub struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    /// The words of a message that must be `length` bytes long.
    pub(super) fn of(bytes: &'a [u8], length: usize) -> Result<Self, Malformed> {
        if bytes.len() == length {
            Ok(Self(bytes))
        } else {
            Err(Malformed)
        }
    }

    pub(super) fn word(&mut self) -> Result<u32, Malformed> {
        self.next().ok_or(Malformed)
    }

    pub(super) fn long(&mut self) -> Result<u64, Malformed> {
        Ok(u64::from(self.word()?) | u64::from(self.word()?) << 32)
    }

    pub(super) fn float(&mut self) -> Result<f32, Malformed> {
        self.word().map(f32::from_bits)
    }
}

impl Iterator for Words<'_> {
    type Item = u32;

    fn next(&mut self) -> Option<u32> {
        let (word, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u32::from_le_bytes(*word))
    }
}
