//! Bits that turn over by themselves while a test runs on the flashed image: what becomes of the test.
//!
//! ```text
//!  target     where a bit turns over, and how it is drawn
//!  pc         a PC that goes by the board's time
//!  trial      one test, from which a process of its own goes off at each flip
//!  outcome    what became of it, against the same test without a flip
//!  table      the shares, and how large the dangerous one may be
//! ```
//!
//! The test runs once without a flip. It runs once more, and where a bit is due the process is copied (`fork`): the copy
//! turns it over, watches what follows and ends; the original goes on to the next. So nothing is booted, loaded and started but
//! twice, and everything that the copies share is the same to the bit.

mod outcome;
mod pc;
mod table;
mod target;
mod trial;

pub use outcome::Outcome;
pub use table::{Table, upper_bound};
pub use target::Target;
pub use trial::{Trials, run};
