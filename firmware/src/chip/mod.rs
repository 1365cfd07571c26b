//! The chip, in two folders: [`stm32`] has the parts shared by the family, [`f429`] those of this one.
//!
//! embassy takes one chip per build, and so does an image: [`this`] is the one selected by the features. The shared
//! half requires of it:
//!
//! | module | contents |
//! |---|---|
//! | `clocks` | `CORE_HZ`, `TIMER_HZ`; check of the external clock before use, the tree, the guard of that clock |
//! | `supply` | the guard of the supply, whose interrupt is a way out |
//! | `reset` | the cause of the chip's start |
//! | `debug` | keeps the watchdog running, whatever a debugger has set |
//! | `period` | the sampling timer, and the one started by it whose compare is the instant of the command |
//! | `store` | saved data, in flash that can be written while the program runs |
//! | `core_coupled` | memory for the queues between interrupt and tasks, and the rig watch |
//!
//! `spi`, `adc`, `dac` and `conversion` serve the converters of a board.

pub mod stack;

#[cfg(feature = "stm32")]
pub mod stm32;

#[cfg(feature = "stm32f429zi")]
pub mod f429;

#[cfg(feature = "stm32f429zi")]
pub use f429 as this;
