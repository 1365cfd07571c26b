//! What the control loop wants from a board: samples in, commands out, and a clock to time itself by.

use outerloop_core::Sample;

/// The analogue side of a board, in SI units; codes, scales and offsets are its own.
pub trait Converters<const N: usize> {
    /// The sample of this control period, with what the board has to report about it. Never waits.
    fn sample(&mut self) -> Sample<N>;

    /// Sends the command for the next period, m. Without `permit` the actuator may not move on it.
    fn command(&mut self, command_m: &[f32; N], permit: bool);
}

/// A free-running counter of processor time.
pub trait Stopwatch {
    /// Ticks from `earlier`, a value of [`now`](Self::now), to `later`. Right if less than a turn of the counter lies between.
    fn between(earlier: u32, later: u32) -> u32;

    /// The counter.
    fn now(&self) -> u32;
}
