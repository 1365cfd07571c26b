//! TIM2, which the laboratory counts along with.

use super::Laboratory;
use crate::chain::Instant;
use crate::nucleo::Nucleo;
use crate::registers::{TIM2_ARR, TIM2_CR2, TIM2_PSC};
use rigless::emulator::Host;
use rigless::session::Session;
use rigless::soc::stm32f427::peripherals::rcc::Apb;
use rigless::time::VirtualNanos;

/// The update by software in `TIM2_EGR`.
pub(super) const UG: u64 = 1;
const MMS: u64 = 7 << 4;

/// The sampling timer as it runs.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampling {
    pub(super) timer_hz: u64,
    pub(super) next_ns: u64,
    /// What the nanoseconds leave over, in 1/timer_hz of a nanosecond.
    rest: u64,
    pub(super) period_ticks: u64,
}

impl Sampling {
    /// The update after this one, with the period that is then in force.
    pub(super) fn advance(&mut self, period_ticks: u64) {
        let ns = self.period_ticks * 1_000_000_000 + self.rest;
        self.next_ns += ns / self.timer_hz;
        self.rest = ns % self.timer_hz;
        self.period_ticks = period_ticks;
    }
}

impl Laboratory {
    /// TIM2 starts to count: its first update is a period away.
    pub(super) fn begin_sampling(&mut self, session: &mut Session<Nucleo>, at: VirtualNanos) {
        let (rcc, registers) = session.board_mut().chip.clocks();
        let timer_hz = rcc.timer_clock(registers, Apb::One) / (self.registers.read(TIM2_PSC) + 1);
        let period_ticks = self.registers.read(TIM2_ARR) + 1;
        let mut sampling = Sampling {
            timer_hz,
            next_ns: at.0,
            rest: 0,
            period_ticks,
        };
        sampling.advance(period_ticks);
        session.pause_at(Some(VirtualNanos(sampling.next_ns)));
        session.run_until(VirtualNanos(sampling.next_ns));
        self.sampling = Some(sampling);
    }

    /// An update by software is an update: it restarts the count, and leaves the timer as a trigger, under the reset value
    /// of MMS too.
    pub(super) fn update_by_software(
        &mut self,
        session: &mut Session<Nucleo>,
        now: Instant,
        host: &mut dyn Host,
    ) {
        if let Some(sampling) = &mut self.sampling {
            let period_ticks = self.registers.read(TIM2_ARR) + 1;
            (sampling.next_ns, sampling.rest) = (now.at.0, 0);
            sampling.period_ticks = period_ticks;
            sampling.advance(period_ticks);
        }
        if matches!(self.registers.read(TIM2_CR2) & MMS, 0 | 0x20) {
            self.convert(session, now, host);
        }
    }
}
