//! What a terminal alone has: progress, interruption, lines as wide as it is.

pub mod bond;
pub mod interrupt;
pub mod misspelt;
pub mod output;
pub mod progress;

pub use progress::{Progress, Steps, while_waiting};
