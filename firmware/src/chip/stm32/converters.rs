//! What the control interrupt requires of the converters of a board: the chip's own, or external ones.

use crate::chip::this::period::Period;
use link::telemetry::MAX_INPUTS;
use link::{CodeRange, Input};

/// Two inputs and an output for each of `A` actuators around one sampling timer.
pub trait Converters<const A: usize = 1>: Sized {
    /// What they take of the chip: its peripherals and its pins.
    type Parts;

    /// Widths of their codes.
    const CODES: CodeRange;
    /// What is recorded beside displacement and force.
    const INPUTS: &'static [Input];
    /// By how much a command read back may be off, in codes of the command.
    const READ_BACK_OFF: u16;
    /// The same over a long stroke, where a code is a long way.
    const READ_BACK_LEAST: u16 = Self::READ_BACK_OFF;
    /// Volts at the ends of their codes.
    const INPUT_SPAN_V: [f32; 2];
    /// From the sampling trigger to the instant at which the output takes the command over, us.
    const OUTPUT_DELAY_US: u32;
    /// The same for steps that take longer.
    const LATE_OUTPUT_DELAY_US: u32 = Self::OUTPUT_DELAY_US;
    /// From the sampling trigger to the beginning of the step, at most, us.
    const BEGINS_US: u32;
    /// Where the timer stands at the latest when a step begins, us: a step that begins later than this was held up.
    const LATEST_BEGIN_US: u32;
    /// Cycles that reading the sample and writing the command take beside the step, with the board's own work around it.
    const AROUND_STEP_CYCLES: u32;

    /// Ready, with a period of `ticks` and the timer standing. Each output stands at the code that `standing` gives for its
    /// actuator and that one's first displacement.
    fn new(
        parts: Self::Parts,
        ticks: u32,
        standing: impl Fn(usize, u16) -> u16,
    ) -> StartedConverters<Self, A>;

    /// Switches the control interrupt on, with the highest priority.
    ///
    /// # Safety
    /// What its handler uses has been put in place.
    unsafe fn enable_interrupt();

    /// The sample of this step, displacement and force of each actuator; `None` if there is none.
    fn codes(&mut self) -> Option<[[u16; 2]; A]>;

    /// The further inputs of that sample.
    fn inputs(&self) -> [u16; MAX_INPUTS];

    /// The converters' own registers, read now, hold what the start has put there: an external chip that lost its supply,
    /// and a peripheral that was reset with another one, do not.
    fn is_set_up(&mut self) -> bool;

    /// The code that an actuator's output shows from its next instant on.
    fn write(&mut self, actuator: usize, code: u16);
}

/// Converters that have just been set up.
pub struct StartedConverters<C, const A: usize = 1> {
    /// The converters.
    pub converters: C,
    /// The control period, which does not run yet.
    pub period: Period,
    /// Codes of a first sample.
    pub first: [[u16; 2]; A],
    /// All that can answer has answered.
    pub answered: bool,
}
