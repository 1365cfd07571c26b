//! What the tasks ask of the control interrupt, and what comes back.

use super::motion::Loaded;
use super::setup::Setup;
use crate::station::commission::Generator;
use heapless::Vec;
use link::MAX_ACTUATORS;
use link::channel::Calibration;
use link::reply::MAX_RECORD;
use link::status::Timing;
use outerloop_core::{Event, Mode, Pace, Rejected, Trip};

/// One for each actuator of a board.
pub type PerActuator<T> = Vec<T, MAX_ACTUATORS>;

/// An order. The interrupt takes one a step, after the command has gone out.
pub enum Order {
    /// From the operator.
    Event(Event),
    /// Another test in place of the present one; while idle.
    Exchange(&'static mut Setup),
    /// The ground motion is wanted back; while idle.
    Unload,
    /// A ground motion; while idle.
    Load(Loaded),
    /// What the next start runs: a commissioning signal, or the test; while idle.
    Signal(Option<Generator>),
    /// Other lines for the channels of an actuator, from 0; while idle.
    Calibrate(u8, Calibration),
    /// Where the targets come from; while idle.
    Pace(Option<Pace>),
    /// The next target of each actuator from the PC, m.
    Target(PerActuator<f32>),
    /// The tests to come are watched, and may be corrected or not; while idle.
    Watch(bool),
    /// A record of the steps before a fault.
    History(u8),
    /// A snapshot of the loop's status.
    LoopStatus,
}

/// What became of an order.
pub struct Outcome {
    /// The first control step with it in force.
    pub tick: u32,
    /// The mode now.
    pub mode: Mode,
    /// What comes back, or why nothing was done.
    pub result: Result<Returned, RefusedOrder>,
}

/// What comes back.
pub enum Returned {
    /// Done.
    Nothing,
    /// The test that was in force before, to be filled anew, and the ground motion, whose steps were the old test's.
    Setup(&'static mut Setup, Option<Loaded>),
    /// The ground motion, if there was one.
    Motion(Option<Loaded>),
    /// A record.
    Record(Vec<u32, MAX_RECORD>),
    /// How the interrupt is.
    LoopStatus(LoopStatus),
}

/// Nothing was done; what was given comes back.
pub enum RefusedOrder {
    /// The event means nothing now, or an interlock stands against it.
    Event(Rejected),
    /// There is no test.
    NotConfigured,
    /// There is nothing to run.
    NothingToRun,
    /// The loop integrates, and no energy error stops it.
    NoEnergyTrip,
    /// A test begins at rest, and an actuator stands under this force, N.
    Strained(f32),
    /// The hold button is pressed.
    Held,
    /// Only while idle.
    NotIdle(Option<Order>),
}

/// How the interrupt is.
#[derive(Clone, Copy, Debug)]
pub struct LoopStatus {
    /// The first fault.
    pub trip: Option<Trip>,
    /// The PERMIT line.
    pub permit: bool,
    /// A test has been accepted.
    pub configured: bool,
    /// Points of the loaded ground motion.
    pub points: u32,
    /// Times.
    pub timing: Timing,
    /// Reports that found the queue full.
    pub dropped_steps: u32,
}
