//! The flashed image, unmodified, on an emulated NUCLEO-F429ZI, with the simulated rig behind its converters.
//!
//! ```text
//!  wire         the serial port's bytes, to and from whoever plays the PC
//!  nucleo       the board: the chip, its crystal, its supply, the serial line
//!  converters   volts, as codes: what the rig shows the ADC, what the DAC tells the rig
//!  laboratory   takes its turn at every period of the sampling timer: rig, converters, faults; keeps a log
//!  image        the ELF, its sizes and symbols
//! ```
//!
//! # What is not as on the metal
//! The emulator has no model of the DAC (its holding register is read instead), no external trigger of the ADC (the
//! laboratory sets the software trigger at the instants at which the sampling timer would), and counts instructions, not
//! cycles of the flash and the pipeline. Both conversions of a pair read the same voltage. Everything else is the chip's:
//! clocks, timers, priorities, DMA, serial port, watchdog, resets.

pub mod converters;
pub mod image;
pub mod laboratory;
pub mod nucleo;
pub mod wire;

pub use image::Firmware;
pub use laboratory::{Fault, Laboratory, Log, Planned, Seen};
pub use wire::Wire;
