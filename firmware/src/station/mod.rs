//! What runs on the board around the control loop, without a pin or a register: it is tested on the host.
//!
//! ```text
//!  control interrupt   Station::tick: sample ─► loop ─► command ─► report ─► one order
//!                           ▲ orders                       │ outcomes, reports
//!  tasks               Service: command ─► order … outcome ─► reply
//! ```
//!
//! The interrupt and the tasks share nothing but three queues that never wait and a few counters ([`Evidence`]). Large
//! things (a new test, the ground motion) change hands as references, so an order costs the interrupt next to nothing.

mod any_loop;
mod commission;
mod evidence;
mod motion;
mod order;
mod period;
mod service;
mod settings;
mod setup;
mod tick;
mod upload;
mod window;

pub use any_loop::AnyLoop;
pub use evidence::{Evidence, PC_PATIENCE_S, Patience, Sign, TASK_PATIENCE_S};
pub use motion::{Loaded, Points, Writable};
pub use order::{Order, Outcome, Refused, Returned, Vitals};
pub use service::{Asked, Board, Parts, Service};
pub use settings::{SETTINGS_BYTES, Settings};
pub use setup::{Clock, Setup};
pub use tick::{Ends, Front, Hardware, Report, Station};
