//! QEMU's `netduinoplus2`: a Cortex-M4F with memory and a SysTick, and the host's files by semihosting.
//!
//! # Limitations
//! None of the STM32's peripherals can be relied on there, so a real board's input and output are not included.

mod exchange;
pub mod image;
mod semihosting;
mod systick;

pub use exchange::{Begin, Exchange};
pub use semihosting::{File, HostGone, Mode, exit};
pub use systick::SysTick;
