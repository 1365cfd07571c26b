//! Spontaneous bit flips while a test runs on the flashed image: what becomes of the test.
//!
//! ```text
//!  target     where a bit flips, and how it is drawn
//!  pc         a PC that runs on the board's time
//!  trial      one test, which forks a process at each flip
//!  outcome    what became of it, compared with the same test without a flip
//!  table      the fractions, and the upper bound of the dangerous one
//! ```
//!
//! The test runs once without a flip. It runs once more, and where a flip is due the process is copied (`fork`): the copy
//! flips the bit, watches what follows and ends; the original goes on to the next. So booting, loading and starting are done
//! only twice, and everything that the copies share is the same to the bit.

mod outcome;
mod pc;
mod table;
mod target;
mod trial;

pub use outcome::Outcome;
pub use table::{Table, upper_bound};
pub use target::Target;
pub use trial::{Trials, run};
