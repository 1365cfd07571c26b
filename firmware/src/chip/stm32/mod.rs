//! Everything that STM32s share, whatever the type and the board: the start, the control interrupt and its state,
//! critical sections, the ways out, data kept across a reset, the tasks, the drills.
//!
//! # Priorities
//! The control interrupt has priority 0, the highest. Everything else is lower and is all that a critical section masks
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

/// For everything but the control interrupt.
pub const BACKGROUND: Priority = Priority::P8;
