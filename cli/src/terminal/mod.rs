//! The terminal: progress, interruption, lines of its width.

pub mod argument_error;
pub mod bond;
pub mod interrupt;
pub mod output;
pub mod progress;

pub use progress::{Progress, Steps, while_waiting};
