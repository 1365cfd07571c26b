//! The laboratory's own count of TIM2.

/// The update by software in `TIM2_EGR`.
pub(super) const UG: u64 = 1;

/// The sampling timer as it runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampling {
    pub(super) timer_hz: u64,
    pub(super) next_ns: u64,
    /// Remainder of the nanoseconds, in 1/timer_hz ns.
    pub(super) rest: u64,
    pub(super) period_ticks: u64,
}

impl Sampling {
    /// Advances to the next update, with the period that this one has loaded.
    pub(super) fn advance(&mut self, period_ticks: u64) {
        let ns = period_ticks * 1_000_000_000 + self.rest;
        self.next_ns += ns / self.timer_hz;
        self.rest = ns % self.timer_hz;
        self.period_ticks = period_ticks;
    }
}
