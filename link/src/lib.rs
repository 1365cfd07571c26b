#![doc = include_str!("../README.md")]
//!
//! # Map
//!
//! ```text
//!  PC ─► board    command    request number, one of [`Command`]
//!  PC ◄─ board    reply      the request's number, one of [`Reply`]
//!  PC ◄─ board    telemetry  every control step, 24 to 42 bytes each, [`telemetry`]
//!
//!  on the wire    COBS( version | kind | sequence number | body | CRC-32 ) 0
//! ```
//!
//! Every frame carries a sequence number of its sender, so the receiver knows what it has lost ([`Continuity`]). An
//! unanswered command is sent again under its old number: the board answers it again but does not execute it twice.
//!
//! # Speed
//! 8N1 at [`BAUD`]: 100 000 bytes a second. Telemetry of every step at 2 kHz takes 64 % of it on the images for one actuator
//! and 84 % on that for three. The board refuses a control rate that would take more than 90 % ([`fastest_rate_hz`]).
//!
//! | look in | for |
//! |---|---|
//! | [`frame`] | bytes to frames and back |
//! | [`message`] | commands and replies to frames and back |
//! | [`command`], [`reply`], [`status`] | requests and answers |
//! | [`telemetry`] | the record of a step in transit |
//! | [`channel`] | converter codes and their meaning in SI units |
//! | [`limits`] | the limits without which no test is armed |

#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod agreed;
pub mod channel;
pub mod command;
pub mod continuity;
pub mod frame;
pub mod limits;
pub mod message;
pub mod reply;
pub mod status;
pub mod telemetry;

pub use agreed::{BAUD, BITS_PER_BYTE, MAX_ACTUATORS, VERSION};
pub use channel::{Calibration, CodeRange};
pub use command::Command;
pub use continuity::Continuity;
pub use frame::{Decoder, Frame, FrameKind};
pub use reply::Reply;
pub use status::Status;
pub use telemetry::{Input, Telemetry};

/// The fastest control rate, Hz, whose telemetry leaves a tenth of the port for replies, on a board with the given
/// numbers of actuators and further inputs.
pub const fn fastest_rate_hz(baud: u32, actuators: usize, inputs: usize) -> u32 {
    let bytes_per_s = baud / BITS_PER_BYTE;
    let frame_bytes = telemetry::frame_bytes(actuators, inputs) as u32;
    bytes_per_s / 10 * 9 / frame_bytes * telemetry::STEPS as u32
}
