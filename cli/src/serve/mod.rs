//! A rig as an element of somebody else's model: OpenSees solves the structure, the rig returns the force.
//!
//! ```text
//!  OpenSees ── genericClient ── wire ── session ── Mover ── core and its rig: simulated, emulated board, board
//!             trial displacement         which trial moves the rig; the reply; what is refused
//! ```
//!
//! | look in | for |
//! |---|---|
//! | `waiting_room` | clients that have connected and are not served yet |
//! | [`wire`] | the bytes |
//! | `session` | one client from its first message to its last |
//! | `element` | the declaration of the rig, and its units on the wire |
//! | `mover` | what a session requires of a rig |
//! | `served_rig` | the rig as a session sees it, control step by control step |
//! | `travel` | from target to target: stop and go, or continuously |
//! | `simulated` | the rig in this process |
//! | `board_rig` | the rig behind a board, emulated or real |
//! | `ledger` | the results of a session: figures, words, JSON |

mod board_rig;
mod element;
mod ledger;
mod mover;
mod served_rig;
mod session;
mod simulated;
mod travel;
mod waiting_room;
pub mod wire;

pub use board_rig::serve_on_board;
pub use element::DeclaredElement;
pub(crate) use element::shear_frame;
pub use ledger::{Ledger, SessionSummary, SessionVerdict};
pub use mover::{Mover, Stop, TargetMeasurement};
pub use session::{Served, serve_client};
pub use simulated::simulated;
pub use waiting_room::{Arrival, WaitingRoom};
