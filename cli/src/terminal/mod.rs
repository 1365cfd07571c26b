//! What a terminal alone has: progress, interruption, lines as wide as it is.

pub mod argument_error;
pub mod bond;
pub mod interrupt;
pub mod output;
pub mod progress;

pub use progress::{Progress, Steps, while_waiting};
