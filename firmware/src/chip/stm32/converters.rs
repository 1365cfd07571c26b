//! The control interrupt's requirements of a board's converters: the chip's own, or external ones.

use crate::chip::this::period::Period;
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};

/// Two inputs and an output for each of `A` actuators on one sampling timer.
pub trait Converters<const A: usize = 1>: Sized {
    /// The parts of the chip they use: peripherals and pins.
    type Parts;

    /// Widths of their codes.
    const CODES: CodeRange;
    /// The inputs recorded besides displacement and force.
    const INPUTS: &'static [Input];
    /// Tolerance of a command read back, in codes of the command.
    const READ_BACK_OFF: u16;
    /// The same for a long stroke, where a code is a large distance.
    const READ_BACK_LEAST: u16 = Self::READ_BACK_OFF;
    /// Voltages at the ends of the input codes.
    const INPUT_SPAN_V: [f32; 2];
    /// From the sampling trigger to the instant at which the output adopts the command, us.
    const OUTPUT_DELAY_US: u32;
    /// The same for steps that take longer.
    const LATE_OUTPUT_DELAY_US: u32 = Self::OUTPUT_DELAY_US;
    /// Latest time from the sampling trigger to the beginning of the step, us.
    const BEGINS_US: u32;
    /// Latest timer reading when a step begins, us: a step that begins later was held up.
    const LATEST_BEGIN_US: u32;
    /// Cycles for reading the sample and writing the command, outside the step, plus the board's own surrounding work.
    const AROUND_STEP_CYCLES: u32;

    /// Ready, with a period of `ticks` and the timer stopped. Each output is at the code that `standing` returns for
    /// its actuator and that one's first displacement.
    fn new(
        parts: Self::Parts,
        ticks: u32,
        standing: impl Fn(usize, u16) -> u16,
    ) -> StartedConverters<Self, A>;

    /// Enables the control interrupt, with the highest priority.
    ///
    /// # Safety
    /// Everything its handler uses must be in place.
    unsafe fn enable_interrupt();

    /// The sample of this step, displacement and force of each actuator; `None` if there is none.
    fn codes(&mut self) -> Option<[[u16; 2]; A]>;

    /// The further inputs of that sample.
    fn inputs(&self) -> [u16; MAX_INPUTS];

    /// True if the converters' own registers, read now, still hold the values from the start: not so for an external
    /// chip that lost its supply, or a peripheral that was reset along with another.
    fn is_set_up(&mut self) -> bool;

    /// Sets the code that an actuator's output shows from its next instant on.
    fn write(&mut self, actuator: usize, code: u16);
}

/// Converters that have just been set up.
pub struct StartedConverters<C, const A: usize = 1> {
    /// The converters.
    pub converters: C,
    /// The control period, not running yet.
    pub period: Period,
    /// Codes of a first sample.
    pub first: [[u16; 2]; A],
    /// True if everything that can answer has answered.
    pub answered: bool,
}
