//! The control period's requirements of a board. None of these functions waits.

use crate::station::heartbeats::Heartbeat;
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};
use outerloop_core::Mode;

/// The inputs and outputs of a board with `A` actuators. Codes are the board's own; it states their width.
pub trait Hardware<const A: usize = 1> {
    /// Widths of the converters' codes.
    const CODES: CodeRange;

    /// The inputs recorded besides displacements and forces, at most [`MAX_INPUTS`].
    const INPUTS: &'static [Input];

    /// Tolerance of a [command read back](Input::CommandReadBack), in codes of the command: the errors of both
    /// converters and of everything between them.
    const READ_BACK_OFF: u16;

    /// Least deviation that counts, whatever distance a code stands for: twice those errors, or all of the tolerance.
    const READ_BACK_LEAST: u16;

    /// Voltages at the ends of the input codes.
    const INPUT_SPAN_V: [f32; 2];

    /// The stopwatch: ticks of the processor, wrapping at 2^32.
    fn now(&self) -> u32;

    /// The codes of displacement and force of each actuator of this step, all sampled at one instant; `None` if there are
    /// no new ones.
    fn codes(&mut self) -> Option<[[u16; 2]; A]>;

    /// The codes of [`INPUTS`](Self::INPUTS), sampled at the same instant as displacement and force; called after
    /// those, when the commands are out.
    fn inputs(&self) -> [u16; MAX_INPUTS];

    /// Queries the converters: true if they are set up as intended. Takes longer than a step's deadline, so it is
    /// called after the command is out.
    fn is_set_up(&mut self) -> bool;

    /// True if this step began later after its sample than anything that runs on the board explains.
    fn began_late(&self) -> bool;

    /// Sets what an actuator's output converter shows from its next instant on, which is common to all. Actuators come
    /// in order, from 0.
    fn output(&mut self, actuator: usize, code: u16);

    /// The PERMIT line; called in every step, so that a pulse can be made of it.
    fn permit(&mut self, on: bool);

    /// True if the contact of the permission's chain is closed: the actuator could move.
    fn permit_chain_closed(&self) -> bool;

    /// True if the emergency stop is pressed, or its wire is broken.
    fn emergency_stop(&self) -> bool;

    /// True if the hold button is pressed.
    fn hold_pressed(&self) -> bool;

    /// Sets the sampling period, in ticks of the sampling timer, from the next step on.
    fn set_period(&mut self, ticks: u32);

    /// Commands leave at a later instant of each period, for steps that take longer, or at the usual one; from the next
    /// step on. No effect on a board whose tests all take equally long.
    fn leave_late(&mut self, _late: bool) {}

    /// Feeds the watchdog.
    fn feed(&mut self);

    /// A task has starved: the watchdog will act. Keeps now what must be known afterwards.
    fn starving(&mut self, task: Heartbeat, tick: u32, mode: Mode);
}
