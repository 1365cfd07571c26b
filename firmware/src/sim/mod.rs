//! The board shared by the tests on the PC: station and service as on hardware, a plant on 12-bit converters, and
//! faults as a wrapper around any board.

mod bench;
mod board;
mod faulty;

pub use bench::{Bench, Tasks};
pub use board::{CLOCK, CODES, Plant, STOPWATCH_PER_TIMER_TICK, SimBoard};
pub use faulty::{Broken, Faulty, Wire};
