//! Who decides whether the command may move: states, interlocks, faults and the last steps before one.

mod fault;
mod interlock;
mod locked;
mod machine;
mod stale;

pub use fault::{Fault, Trip};
pub use interlock::Limits;
pub(crate) use interlock::{Checked, Finding, check};
pub(crate) use locked::LockWatch;
pub use machine::{Event, Rejected, State};
pub(crate) use stale::StaleWatch;

/// Number of steps that are kept from before a fault.
pub const HISTORY: usize = 16;
