//! What every STM32 shares, whichever of them it is and whatever hangs on it: the start, the control interrupt and what it
//! owns, critical sections, the ways out, what is kept across a reset, the tasks, the drills.
//!
//! # Priorities
//! The control interrupt has priority 0, the highest. Everything else has less and is all that a critical section masks
//! ([`critical`]). So nothing that runs on a board delays the control interrupt, and it calls nothing that needs a
//! critical section: no embassy, no defmt.

use embassy_stm32::interrupt::Priority;

pub mod board;
pub mod boot;
pub mod control;
pub mod converters;
mod critical;
pub mod drill;
pub mod fatal;
pub mod kept;
pub mod metal;
mod stack_guard;
pub mod tasks;

/// Of everything but the control interrupt.
pub const BACKGROUND: Priority = Priority::P8;
