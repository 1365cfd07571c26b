//! What the PC and the image in QEMU say to each other over one pipe.
//!
//! ```text
//!  PC ─► image   commands of `link`: ground motion, then configuration   once
//!  PC ◄─ image   replies of `link`
//!
//!  PC ─► image   order, displacements, forces                            every control period
//!  PC ─► image   a command of `link`, the event                          where the order announces one
//!  PC ◄─ image   its reply
//!  PC ◄─ image   permission, commands, record                            every control period
//!
//!  PC ─► image   end
//!  PC ◄─ image   account
//! ```
//!
//! What goes over a board's port goes here, too, as frames of [`link`]. What goes through a board's converters, sample and
//! command, and the whole record, of which telemetry carries a digest, are 32-bit words, least significant byte first:
//! framing them would take longer than the step that is looked at, and the closed loop is to be twenty times faster than
//! real time. The pipe between two processes neither loses nor garbles.

mod account;
mod period;
mod words;

pub use account::SessionAccount;
pub use period::{PeriodReply, PeriodRequest};
pub use words::{Malformed, Message, Words};
