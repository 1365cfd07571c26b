//! The state of the board.

use crate::agreed::MAX_ACTUATORS;
use crate::frame::DecoderCounts;
use heapless::{String, Vec};
use outerloop_core::watch::{Cause, Finding, State};
use outerloop_core::{Mode, Trip};
use serde::{Deserialize, Serialize};

/// Everything that is worth watching.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Status {
    /// Control step since power-up.
    pub tick: u32,
    /// Where the test stands.
    pub mode: Mode,
    /// The first fault, until it is cleared.
    pub trip: Option<Trip>,
    /// The PERMIT line.
    pub permit: bool,
    /// A test has been accepted.
    pub configured: bool,
    /// Somebody has calibrated the channels.
    pub calibrated: bool,
    /// Points of the ground motion that is loaded and checked.
    pub points: u32,
    /// The crystal has the right frequency.
    pub crystal_ok: bool,
    /// The converters answered when the board started; those on the chip always do.
    pub converters_ok: bool,
    /// The codes of the last sample, displacement and force of the first actuator.
    pub codes: [u16; 2],
    /// Those of the others.
    #[cfg_attr(feature = "schema", schemars(with = "[[u16; 2]]"))]
    pub other_codes: Vec<[u16; 2], { MAX_ACTUATORS - 1 }>,
    /// Times of the control step.
    pub timing: Timing,
    /// What the board has received.
    pub link: DecoderCounts,
    /// Telemetry steps that found the queue full and were dropped.
    pub dropped_steps: u32,
    /// Bytes of stack used at most.
    pub stack_bytes: u32,
    /// What the rig watch says of the test in force, where it is watched.
    pub watch: Option<WatchStatus>,
    /// Why the board last started.
    pub started: StartCause,
    /// What the program said last before a start that nobody asked for.
    pub last_crash: Option<CrashReport>,
}

/// Causes that fit in a status: five for each actuator.
pub const MAX_NAMED: usize = 5 * MAX_ACTUATORS;

/// A cause of a set, with its value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NamedCause {
    /// Of which actuator, from 1.
    pub actuator: u8,
    /// What.
    pub cause: Cause,
    /// In the unit of the cause.
    pub value: f32,
    /// Its standard deviation.
    pub sd: f32,
    /// How much of it is corrected for, 0 where nothing is.
    pub corrected: f32,
}

impl NamedCause {
    /// The finding without its actuator.
    pub fn finding(&self) -> Finding {
        Finding {
            cause: self.cause,
            value: self.value,
            sd: self.sd,
        }
    }
}

/// What the rig watch says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WatchStatus {
    /// Of the worst actuator.
    pub state: State,
    /// Since which control step of the running test state and sets have been so, from 0.
    pub since_step: u32,
    /// What is named of each actuator.
    #[cfg_attr(feature = "schema", schemars(with = "[NamedCause]"))]
    pub named: Vec<NamedCause, MAX_NAMED>,
    /// What a compensation learns is held.
    pub held: bool,
    /// Blocks of steps judged since the test is in force.
    pub blocks: u32,
    /// Cycles of the processor, interrupts in between included, that judging a block took at most.
    pub worst_cycles: u32,
    /// And in the mean.
    pub mean_cycles: u32,
}

/// Times of the control step, in cycles of the processor.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Timing {
    /// Cycles of a period as set.
    pub period_cycles: u32,
    /// Shortest distance between the beginnings of two steps.
    pub shortest_period_cycles: u32,
    /// Longest.
    pub longest_period_cycles: u32,
    /// Longest step.
    pub worst_step_cycles: u32,
    /// Mean step.
    pub mean_step_cycles: u32,
    /// Steps that took longer than their deadline.
    pub overruns: u32,
}

/// Why a board started.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum StartCause {
    /// Power came.
    Power,
    /// The supply had been too low.
    BrownOut,
    /// The reset pin: the button, or the debugger.
    Pin,
    /// The program asked for it.
    Software,
    /// The watchdog: nobody had fed it.
    Watchdog,
}

/// What is kept across a reset.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct CrashReport {
    /// What had happened.
    pub cause: CrashCause,
    /// Control step at which it happened.
    pub tick: u32,
    /// Mode of the test at the time.
    pub mode: Mode,
    /// Message of a panic, or registers of a fault.
    #[cfg_attr(feature = "schema", schemars(with = "str"))]
    pub text: String<96>,
}

/// What a program can die of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum CrashCause {
    /// A panic.
    Panic,
    /// A fault of the processor that has no other name.
    HardFault,
    /// The stack grew beyond its end.
    StackOverflow,
    /// A task gave no sign of life, so the watchdog was not fed.
    Starved,
    /// The control interrupt itself had stopped: the watchdog reset the board without a message.
    Silent,
    /// The external clock stopped.
    ClockStopped,
    /// The supply fell below what the chip needs at its clock.
    LowSupply,
    /// PERMIT stayed high after it was dropped, or its port did not take what was written: the watchdog was not fed.
    PermitStays,
}
