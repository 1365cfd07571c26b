//! Addresses at which the STM32F429 has nothing: the processor's access to one ends in a bus fault.
//!
//! By default the emulator answers such a read with zero and drops such a write. A program whose stack has left the memory
//! then continues with values that it never wrote, and whether that is noticed is chance.

use crate::nucleo::Nucleo;
use rigless::emulator::{Driver, Host, Settled, Stop};
use rigless::session::Session;
use rigless::time::VirtualNanos;

/// Start and end (exclusive) of what RM0090's memory map (section 2.3) calls reserved, outside the ranges of the processor's
/// own registers and of the peripherals. The option bytes at 0x1FFF_C000 and 0x1FFE_C000 count as gaps: the image never reads
/// them there.
const GAPS: [(u64, u64); 6] = [
    (0x0020_0000, 0x0800_0000),
    (0x0820_0000, 0x1000_0000),
    (0x1001_0000, 0x1fff_0000),
    (0x1fff_8000, 0x2000_0000),
    (0x2003_0000, 0x2200_0000),
    (0x2400_0000, 0x4000_0000),
];

/// A driver on a chip on which accesses to gaps fail.
pub(crate) struct Guarded(Box<dyn Driver<Nucleo>>);

impl Guarded {
    /// From now on every access to a gap fails.
    pub(crate) fn new(session: &mut Session<Nucleo>, driver: Box<dyn Driver<Nucleo>>) -> Self {
        for (from, to) in GAPS {
            session.fail_next(from, to);
        }
        Self(driver)
    }
}

impl Driver<Nucleo> for Guarded {
    fn on_settled(&mut self, session: &mut Session<Nucleo>, host: &mut dyn Host, settled: Settled) {
        if let Settled::Access { access, .. } = &settled {
            let is_hit = |(from, to): &&(u64, u64)| (*from..*to).contains(&access.address);
            // Each call makes one access fail.
            if let Some(&(from, to)) = GAPS.iter().find(is_hit) {
                session.fail_next(from, to);
                return;
            }
        }
        self.0.on_settled(session, host, settled);
    }

    fn on_stop(
        &mut self,
        session: &mut Session<Nucleo>,
        stop: Stop,
        host: &mut dyn Host,
    ) -> Option<VirtualNanos> {
        self.0.on_stop(session, stop, host)
    }
}
