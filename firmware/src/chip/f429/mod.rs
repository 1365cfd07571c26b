//! The STM32F429: its clocks, its flash, its memory, its timers and converters.

pub mod adc;
pub mod clocks;
pub mod conversion;
pub mod core_coupled;
pub mod dac;
pub mod debug;
pub mod period;
pub mod reset;
pub mod spi;
pub mod store;
pub mod supply;
