//! The flashed image, unmodified, on an emulated NUCLEO-F429ZI, with the simulated rig behind its converters.
//!
//! ```text
//!  wire         the serial port's bytes, to and from whoever plays the PC
//!  nucleo       the board: the chip, its crystal, its supply, the serial line
//!  chain        the converters between rig and chip: its own ADC and DAC, or an AD7606 and an AD5761R or AD5754R on its SPI
//!  registers    what the image writes where the emulator has no model, and what it must have written
//!  rig          the simulated rig, of either kind
//!  servo        what goes wrong between command and rig
//!  permission   what hangs on PERMIT: monostable, relay, contact
//!  laboratory   takes its turn at every period of the sampling timer: rig, converters, faults
//!  log          what can go wrong there, and what is seen
//!  processor    the emulator's, with what is around it:
//!  cores        what it has translated, kept over resets and for the next board
//!  flash        the array behind the flash's controller
//!  core_bits    a bit that turns over in its registers and its memory
//!  flips        bits that turn over by themselves in a running test
//!  image        the ELF, its sizes and symbols
//!  gaps         addresses at which the chip has nothing
//!  run          power on
//! ```
//!
//! # What is not as on the metal
//! The emulator has no lines between timers and converters: the laboratory reads what the image has written into their
//! registers, starts the conversions at the updates of the sampling timer, and hands commands over at TIM4's compare, only
//! where the chip would. Every instruction takes the mean of what the chip takes (`nucleo::INSTRUCTIONS_PER_SECOND`): no
//! pipeline, no flash, no bus contention. Both conversions of a pair read the same voltage. Everything else is the
//! emulator's model of the chip: clocks, timers, priorities, DMA, serial port, watchdog, resets.

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
pub use registers::{Mutant, Violation};
pub use rig::AnyRig;
pub use run::run;
pub use wire::Wire;
