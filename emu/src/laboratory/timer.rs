//! TIM2, which the laboratory counts along with.

/// The update by software in `TIM2_EGR`.
pub(super) const UG: u64 = 1;

/// The sampling timer as it runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampling {
    pub(super) timer_hz: u64,
    pub(super) next_ns: u64,
    /// What the nanoseconds leave over, in 1/timer_hz of a nanosecond.
    pub(super) rest: u64,
    pub(super) period_ticks: u64,
}

impl Sampling {
    /// The update after this one, with the period that this one has put in force.
    pub(super) fn advance(&mut self, period_ticks: u64) {
        let ns = period_ticks * 1_000_000_000 + self.rest;
        self.next_ns += ns / self.timer_hz;
        self.rest = ns % self.timer_hz;
        self.period_ticks = period_ticks;
    }
}
