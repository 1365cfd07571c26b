#![doc = include_str!("../README.md")]
//!
//! # Map
//!
//! ```text
//!  station     runs on every board: the control period (station/period.rs), commands, upload, calibration, limits
//!  hardware    its requirements of a board: one trait
//!  chip        what all chips of the family share (start, control interrupt, ways out, tasks), and one folder per chip
//!  converter   external converters, according to their data sheets
//!  board/X     one folder per board: what is wired to which pin, and its converters. bin/X: an image
//!  sim         the board shared by the tests on the PC
//!  session     the QEMU image's protocol with its driver
//! ```
//!
//! The station knows no pin and no board knows the algorithm. `src/bin` holds the images, built by `scripts/cross`. The
//! hardware-independent half builds and is tested on the PC, too.

#![cfg_attr(target_os = "none", no_std)]
// Limits are written `!(x <= limit)` so that a NaN fails them.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod board;
#[cfg(target_os = "none")]
pub mod chip;
#[cfg(all(target_os = "none", feature = "stm32"))]
pub mod converter;
pub mod hardware;
mod image;
pub mod session;
#[cfg(not(target_os = "none"))]
pub mod sim;
pub mod station;
pub mod step_time;
