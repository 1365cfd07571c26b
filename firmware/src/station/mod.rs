//! Everything that runs on every board around the outer loop, without a pin or a register: it is tested on the PC.
//!
//! ```text
//!  control interrupt   period: sample ─► step ─► command ─► report; then one order (carry_out)
//!                           ▲ orders                       │ outcomes, reports
//!  tasks               service: command ─► order … outcome ─► reply; watchers: block ─► answer
//! ```
//!
//! Interrupt and tasks share only four queues that never wait and a few counters ([`Heartbeats`], [`Judged`]). Large
//! objects (a new test, the ground motion) change hands as references: an order costs the interrupt next to nothing.

mod any_loop;
mod carry_out;
mod chain;
mod commission;
pub(crate) mod heartbeats;
mod motion;
mod order;
mod period;
mod permission;
mod read_back;
mod rehearsal;
mod ring;
mod sensors;
mod service;
mod settings;
mod setup;
mod spacing;
mod twice;
pub(crate) mod upload;
mod watchers;
mod window;

pub use any_loop::AnyLoop;
pub use chain::CHAIN_TIMEOUT_S;
pub use heartbeats::{Heartbeat, Heartbeats, PC_TIMEOUT_S, TASK_TIMEOUT_S, Timeouts};
pub use motion::{Loaded, Points, Writable};
pub use order::{LoopStatus, Order, Outcome, PerActuator, RefusedOrder, Returned};
pub use period::{QueueEnds, Report, ReportQueue, Station};
pub use ring::{Flash, Ring};
pub use service::{Board, CommandResult, Parts, Service};
pub use settings::{CALIBRATION_BYTES, FlashRecord, TEST_BYTES, Wiring};
pub use setup::{Clock, Setup};
pub use watchers::{
    FromWatch, Judged, OrdersQueue, WatchParts, Watched, Watchers, Watches, pass_on,
};
