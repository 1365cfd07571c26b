//! The PC's side of a board.
//!
//! ```text
//!  port         bytes: a serial port, or the pipes of an emulator
//!  connection   commands and their answers, telemetry in the order of its steps
//!  mirror       the same loop on the PC, fed with the board's codes: every word of every record, proven by its digest
//!  bench        a whole test: configure, load, arm, start, receive
//!  orders       what a person asks of a board, and how a refusal is said
//!  wording      what a board says, in words
//! ```

mod bench;
mod commission;
mod connection;
pub mod emulated;
mod mirror;
mod orders;
mod port;
mod wording;

pub use bench::BoardBench;
pub use commission::commission;
pub use connection::{Connection, Patience};
pub use mirror::{Mirror, Seen};
pub use orders::{calibrate, clear, identify, save, status, zero};
pub use port::{Port, Serial};
pub use wording::{describe, describe_words};
