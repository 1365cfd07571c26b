//! Updates of TIM2: the first, and those by software.

use super::Laboratory;
use super::timer::Sampling;
use crate::chain::Instant;
use crate::nucleo::Nucleo;
use crate::registers::{TIM2_ARR, TIM2_CR2, TIM2_PSC};
use rigless::emulator::Host;
use rigless::session::Session;
use rigless::soc::stm32f427::peripherals::rcc::Apb;
use rigless::time::VirtualNanos;

/// The timer's trigger output.
const MMS: u64 = 7 << 4;

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

    /// An update by software counts as an update: it restarts the count and is sent out as a trigger, also with the reset value
    /// of MMS.
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
