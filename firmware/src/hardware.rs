//! What the control period requires of a board. Nothing of it waits.

use crate::station::heartbeats::Heartbeat;
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};
use outerloop_core::Mode;

/// The inputs and outputs of a board with `A` actuators. Codes are the board's own; how wide they are, it says.
pub trait Hardware<const A: usize = 1> {
    /// Widths of the converters' codes.
    const CODES: CodeRange;

    /// What is recorded beside displacements and forces, at most [`MAX_INPUTS`].
    const INPUTS: &'static [Input];

    /// By how much a [command read back](Input::CommandReadBack) may be off, in codes of the command: the errors of both
    /// converters and of what is between them.
    const READ_BACK_OFF: u16;

    /// By how much it may be off whatever way the calibration makes of a code: what these errors are twice as large as.
    const READ_BACK_LEAST: u16;

    /// Volts at the ends of their codes.
    const INPUT_SPAN_V: [f32; 2];

    /// The stopwatch: ticks of the processor, turning over at 2^32.
    fn now(&self) -> u32;

    /// The codes of displacement and force of each actuator of this step, all sampled at one instant; `None` if there are
    /// no new ones.
    fn codes(&mut self) -> Option<[[u16; 2]; A]>;

    /// The codes of [`INPUTS`](Self::INPUTS), sampled at the same instant as displacement and force; asked after those,
    /// when the commands are out.
    fn inputs(&self) -> [u16; MAX_INPUTS];

    /// The converters, asked now, say that they are set up as they should be. Takes longer than a step's deadline: for
    /// when its command is out.
    fn is_set_up(&mut self) -> bool;

    /// This step began later after its sample than anything that runs on the board explains.
    fn began_late(&self) -> bool;

    /// What an actuator's output converter is to show from its next instant on, that of all of them. Actuators come in
    /// their order, from 0.
    fn output(&mut self, actuator: usize, code: u16);

    /// The PERMIT line; called in every step, so that a pulse can be made of it.
    fn permit(&mut self, on: bool);

    /// The contact of the permission's chain is closed: the actuator could move.
    fn permit_chain_closed(&self) -> bool;

    /// The emergency stop is pressed, or its wire is broken.
    fn emergency_stop(&self) -> bool;

    /// The hold button is pressed.
    fn hold_pressed(&self) -> bool;

    /// The period of sampling, in ticks of the sampling timer, from the next step on.
    fn set_period(&mut self, ticks: u32);

    /// The commands leave at a later instant of each period, for steps that take longer, or at their usual one; from the next step
    /// on. Without effect on a board whose tests all take as long.
    fn leave_late(&mut self, _late: bool) {}

    /// Feeds the watchdog.
    fn feed(&mut self);

    /// A task has starved: the watchdog will act. What is to be known afterwards is kept now.
    fn starving(&mut self, task: Heartbeat, tick: u32, mode: Mode);
}
