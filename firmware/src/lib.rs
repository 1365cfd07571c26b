//! The control loop on a microcontroller.
//!
//! ```text
//!              timer            sample            command
//!  hardware-independent:  control_loop ── converters (a trait) ──┐
//!                              │                                 │
//!                              └─ outerloop_core::OuterLoop      │
//!  one file a board:      board/qemu: semihosting for converters ┘
//! ```
//!
//! The loop knows no pin and no board knows the algorithm. `src/bin` holds the images, each a page long; they are
//! built for the target by `scripts/cross`. The half without hardware builds and is tested on the host too.

#![cfg_attr(target_os = "none", no_std)]
// `!(x <= limit)` is how a NaN fails a limit.
#![allow(clippy::neg_cmp_op_on_partial_ord)]

pub mod board;
pub mod control_loop;
pub mod converters;
pub mod session;
pub mod station;
pub mod step_time;
