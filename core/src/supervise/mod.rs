//! Decides whether the command may move: modes, interlocks, faults and the last steps before a fault.

mod fault;
mod history;
mod interlock;
mod locked;
pub(crate) mod mode;
mod stale;

pub use fault::{Fault, Trip};
pub use history::HISTORY;
pub(crate) use history::History;
pub use interlock::InterlockLimits;
pub(crate) use interlock::{Checked, Finding, first_fault, within};
pub(crate) use locked::LockWatch;
pub use mode::{Event, Mode, OBSTACLE_STEPS, Rejected};
pub(crate) use stale::{StaleWatch, Staleness};
