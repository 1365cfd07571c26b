//! The board that the tests on this machine share: station and service as on the metal, a plant behind converters of 12
//! bits, and what can go wrong as a wrapper around any board.

mod bench;
mod board;
mod faulty;

pub use bench::{Bench, Tasks};
pub use board::{CLOCK, CODES, Plant, STOPWATCH_PER_TIMER_TICK, SimBoard};
pub use faulty::{Broken, Faulty, Wire};
