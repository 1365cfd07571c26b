//! What a chip is, in two folders: [`stm32`] has what all of the family share, [`f429`] what only this one has.
//!
//! embassy takes one chip a build, and so does an image: [`this`] is the one that the features name. What the shared half
//! requires of it:
//!
//! | module | what |
//! |---|---|
//! | `clocks` | `CORE_HZ`, `TIMER_HZ`; the external clock looked at before it is used, the tree, the guard of that clock |
//! | `supply` | the guard of the supply, whose interrupt is a way out |
//! | `reset` | what made the chip start |
//! | `debug` | the watchdog counts on, whatever a debugger has set |
//! | `period` | the sampling timer, and the one behind it whose compare is the instant of the command |
//! | `store` | what is saved, in flash that can be written while the program runs |
//! | `core_coupled` | memory for the queues between interrupt and tasks, and the rig watch |
//!
//! `spi`, `adc`, `dac` and `conversion` are for the converters of a board.

pub mod stack;

#[cfg(feature = "stm32")]
pub mod stm32;

#[cfg(feature = "stm32f429zi")]
pub mod f429;

#[cfg(feature = "stm32f429zi")]
pub use f429 as this;
