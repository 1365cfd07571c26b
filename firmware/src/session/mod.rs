//! The protocol between the PC and the image in QEMU, over one pipe.
//!
//! ```text
//!  PC ─► image   commands of `link`: ground motion, then configuration   once
//!  PC ◄─ image   replies of `link`
//!
//!  PC ─► image   order, displacements, forces                            every control period
//!  PC ─► image   a command of `link`, the event                          if the order announces one
//!  PC ◄─ image   its reply
//!  PC ◄─ image   permission, commands, record                            every control period
//!
//!  PC ─► image   end
//!  PC ◄─ image   account
//! ```
//!
//! Messages of a board's port are frames of [`link`] here, too. The traffic of a board's converters (sample and
//! command) and the whole record, of which telemetry has only a digest, are 32-bit words, least significant byte first:
//! framing them would take longer than the step being observed, and the closed loop has to run twenty times faster than
//! real time. A pipe between two processes neither loses nor corrupts data.

mod account;
mod period;
mod words;

pub use account::SessionAccount;
pub use period::{PeriodReply, PeriodRequest};
pub use words::{Malformed, Message, Words};
