//! The flashed image, unmodified, on an emulated NUCLEO-F429ZI, with the simulated rig behind its converters.
//!
//! ```text
//!  wire         the serial port's bytes, to and from the program that acts as the PC
//!  nucleo       the board: the chip, its crystal, its supply, the serial line
//!  chain        the converters between rig and chip: its own ADC and DAC, or an AD7606 and an AD5761R or AD5754R on its SPI
//!  registers    what the image writes where the emulator has no model, and what it must have written
//!  rig          the simulated rig, of either kind
//!  servo        faults between command and rig
//!  permission   the chain driven by PERMIT: monostable, relay, contact
//!  laboratory   runs at every period of the sampling timer: rig, converters, faults
//!  log          the faults there, and the events and values logged
//!  processor    the emulator's, with additions:
//!  cores        its translations, kept over resets and for the next board
//!  flash        the memory array of the flash
//!  core_bits    bit flips in its registers and its memory
//!  flips        spontaneous bit flips in a running test
//!  image        the ELF, its sizes and symbols
//!  gaps         addresses at which the chip has nothing
//!  run          power on
//! ```
//!
//! # What differs from the hardware
//! The emulator has no lines between timers and converters: the laboratory reads what the image has written into their
//! registers, starts the conversions at the updates of the sampling timer, and loads commands at TIM4's compare, only
//! where the chip would. Every instruction takes the chip's mean time (`nucleo::INSTRUCTIONS_PER_SECOND`): no pipeline, no
//! flash wait states, no bus contention. Both conversions of a pair read the same voltage. Everything else is the emulator's
//! model of the chip: clocks, timers, priorities, DMA, serial port, watchdog, resets.

#![cfg(feature = "emulator")]

pub mod chain;
#[cfg_attr(not(unix), allow(dead_code))]
mod core_bits;
mod cores;
mod flash;
#[cfg(unix)]
pub mod flips;
mod gaps;
pub mod image;
pub mod laboratory;
pub mod log;
pub mod nucleo;
pub mod permission;
mod processor;
pub mod registers;
mod rig;
mod run;
pub mod servo;
pub mod wire;

pub use chain::Converters;
pub use core_bits::CoreBits;
pub use image::Firmware;
pub use laboratory::Laboratory;
pub use log::{InjectedFault, Log, LoggedEvent, PlannedFault};
pub use permission::Contact;
pub use registers::{Mutant, ResetLine, Violation};
pub use rig::AnyRig;
pub use run::run;
pub use wire::Wire;
