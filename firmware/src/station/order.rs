//! The tasks' orders to the control interrupt, and its results.

use super::motion::Loaded;
use super::setup::Setup;
use crate::station::commission::Generator;
use heapless::Vec;
use link::MAX_ACTUATORS;
use link::channel::Calibration;
use link::reply::{MAX_RECORD, NotReady};
use link::status::Timing;
use outerloop_core::{Event, Mode, Pace, Rejected, Trip};

/// A value for each actuator of a board.
pub type PerActuator<T> = Vec<T, MAX_ACTUATORS>;

/// An order. The interrupt takes one per step, after the command has gone out.
pub enum Order {
    /// From the operator.
    Event(Event),
    /// Replaces the present test by another; while idle.
    Exchange(&'static mut Setup),
    /// Returns the ground motion; while idle.
    Unload,
    /// A ground motion; while idle.
    Load(Loaded),
    /// The next start runs a commissioning signal, or the test; while idle.
    Signal(Option<Generator>),
    /// New calibration lines for the channels of an actuator, from 0; while idle.
    Calibrate(u8, Calibration),
    /// The source of the targets; while idle.
    Pace(Option<Pace>),
    /// The next target of each actuator from the PC, m.
    Target(PerActuator<f32>),
    /// Coming tests are watched, and may be corrected or not; while idle.
    Watch(bool),
    /// A record of the steps before a fault.
    History(u8),
    /// A snapshot of the loop's status.
    LoopStatus,
}

/// The result of an order.
pub struct Outcome {
    /// The first control step for which it was in force.
    pub tick: u32,
    /// The mode now.
    pub mode: Mode,
    /// What is returned, or why nothing was done.
    pub result: Result<Returned, RefusedOrder>,
}

/// What an order returns.
pub enum Returned {
    /// Done.
    Nothing,
    /// The previous test, for reuse, and the ground motion, whose mapping was for the old test.
    Setup(&'static mut Setup, Option<Loaded>),
    /// The ground motion, if there was one.
    Motion(Option<Loaded>),
    /// A record.
    Record(Vec<u32, MAX_RECORD>),
    /// The state of the interrupt.
    LoopStatus(LoopStatus),
}

/// Nothing was done; returns what was passed in.
pub enum RefusedOrder {
    /// The event is invalid now, or an interlock forbids it.
    Event(Rejected),
    /// There is no test.
    NotConfigured,
    /// There is nothing to run.
    NothingToRun,
    /// Something else that arming or starting demands is not so; the value, if it has one.
    NotReady(NotReady, Option<f32>),
    /// Only while idle.
    NotIdle(Option<Order>),
}

/// The state of the interrupt.
#[derive(Clone, Copy, Debug)]
pub struct LoopStatus {
    /// The first fault.
    pub trip: Option<Trip>,
    /// The PERMIT line.
    pub permit: bool,
    /// True if a test has been accepted.
    pub configured: bool,
    /// Points of the loaded ground motion.
    pub points: u32,
    /// Times.
    pub timing: Timing,
    /// Reports lost to a full queue.
    pub dropped_steps: u32,
}
