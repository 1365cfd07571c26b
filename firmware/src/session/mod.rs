//! What the PC and the image in QEMU say to each other over one pipe.
//!
//! ```text
//!  PC ─► image   commands of `link`: ground motion, then configuration   once
//!  PC ◄─ image   replies of `link`
//!
//!  PC ─► image   order, displacements, forces                            every control period
//!  PC ─► image   a command of `link`, the event                          where the order announces one
//!  PC ◄─ image   its reply
//!  PC ◄─ image   permission, commands, record                            every control period
//!
//!  PC ─► image   end
//!  PC ◄─ image   summary
//! ```
//!
//! What goes over a board's port goes here, too, as frames of [`link`]. What goes through a board's converters, sample and
//! command, and the whole record, of which telemetry carries a digest, are 32-bit words, least significant byte first:
//! framing them would take longer than the step that is looked at, and the closed loop is to be twenty times faster than
//! real time. The pipe between two processes neither loses nor garbles.

mod period;
mod summary;

pub use period::{Order, Output};
pub use summary::Summary;

use outerloop_core::Record;
use outerloop_core::config::MAX_DOF;

/// Bytes of the longest message: an output with the record of [`MAX_DOF`] degrees of freedom.
const MAX_BYTES: usize = 4 * (1 + MAX_DOF + Record::<MAX_DOF>::WORDS);

/// A message as it is sent.
pub type Message = heapless::Vec<u8, MAX_BYTES>;

/// A message that does not mean anything.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed;

/// Appends a word; every message fits by the length that [`MAX_BYTES`] was made for.
fn push(message: &mut Message, word: u32) {
    let fits = message.extend_from_slice(&word.to_le_bytes());
    debug_assert!(fits.is_ok());
}

fn push_long(message: &mut Message, long: u64) {
    push(message, long as u32);
    push(message, (long >> 32) as u32);
}

/// The words of a message, in their order.
#[derive(Clone, Debug)]
pub struct Words<'a>(&'a [u8]);

impl<'a> Words<'a> {
    /// Of a message that must be `length` bytes long.
    fn of(bytes: &'a [u8], length: usize) -> Result<Self, Malformed> {
        if bytes.len() == length {
            Ok(Self(bytes))
        } else {
            Err(Malformed)
        }
    }

    fn word(&mut self) -> Result<u32, Malformed> {
        self.next().ok_or(Malformed)
    }

    fn long(&mut self) -> Result<u64, Malformed> {
        Ok(u64::from(self.word()?) | u64::from(self.word()?) << 32)
    }

    fn float(&mut self) -> Result<f32, Malformed> {
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
