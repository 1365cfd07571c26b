#![doc = include_str!("../README.md")]
//!
//! # Map
//!
//! ```text
//!  station     what runs on every board: the control period (station/period.rs), commands, upload, calibration, limits
//!  hardware    what it requires of a board: one trait
//!  board/X     one folder a board: pins, clocks, converters, flash. bin/X: its start and its tasks
//!  sim         the board that the tests on this machine share
//!  session     the QEMU image's talk with its driver
//! ```
//!
//! The station knows no pin and no board knows the algorithm. `src/bin` holds the images, built by `scripts/cross`. The
//! half without hardware builds and is tested on this machine too.

#![cfg_attr(target_os = "none", no_std)]
// `!(x <= limit)` is how a NaN fails a limit.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod board;
pub mod hardware;
pub mod session;
#[cfg(not(target_os = "none"))]
pub mod sim;
pub mod station;
pub mod step_time;
