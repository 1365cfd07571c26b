//! The PC's side of a board.
//!
//! ```text
//!  port         bytes: a serial port, or the pipes of an emulator
//!  in_turns     the port to an emulated board, whose time stands still while this program computes
//!  connection   commands and their replies, telemetry in the order of its steps
//!  mirror       the same loop on the PC, fed with the board's codes: every word of every record, proven by its digest
//!  setup        a board before a test: idle, calibrated, with limits that can act
//!  configured_test a test in force: events, targets, every step, the end
//!  bench        a whole test: configure, load, arm, start, receive
//!  desk         a bare board with four wires: what it does, row by row
//!  image        the images that can be flashed
//!  cross_readings  readings of every actuator while one is moved: stiffness, and exchanged wires
//!  trajectory   a motion of the actuator without a test: a formula or points
//!  limits       those that a board requires, computed from the planned test
//!  operator     the person at the bench: start, resume, stop
//!  standing     where the pistons stand, as a person says and as the board reads
//!  orders       commands from a person to a board, and the sentence for a refusal
//!  wording      what a board reports, in words
//! ```

mod bench;
mod build;
mod commission;
mod configured_test;
mod connection;
mod cross_readings;
pub mod desk;
pub mod emulated;
mod image;
pub mod in_turns;
pub mod limits;
mod mirror;
pub mod operator;
mod orders;
mod port;
mod setup;
pub mod standing;
mod trajectory;
mod upload;
mod wording;

pub use bench::BoardBench;
pub(crate) use bench::coupled_test;
pub use commission::commission;
pub use configured_test::ConfiguredTest;
pub use connection::{BoardConnection, Connection, Timeouts};
pub use image::Image;
pub(crate) use mirror::DIFFERS;
pub use mirror::{Mirror, MirrorCounts};
pub use operator::Operator;
pub(crate) use orders::done;
pub use orders::{calibrate, calibrate_one, clear, identify, save, status, zero};
pub use port::{Port, Serial};
pub(crate) use setup::{Hold, ready};
pub use standing::PistonsAt;
pub use trajectory::Trajectory;
pub use wording::describe_words;
