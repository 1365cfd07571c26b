//! Spontaneous bit flips in registers of peripherals and on the way from and to the converters.

use super::Laboratory;
use crate::nucleo::Nucleo;
use crate::registers::KEPT;
use rigless::emulator::{Access, AccessKind, Driver, Host, Settled, Stop};
use rigless::session::Session;
use rigless::soc::Width;

/// Offset of a port's output register; its set and reset register is the next word.
const ODR: u64 = 0x14;
const PORTS: std::ops::Range<u64> = 0x4002_0000..0x4002_2000;

impl Laboratory {
    /// A bit of a register flips, as if the program had written it.
    pub(crate) fn turn_over_register(
        &mut self,
        session: &mut Session<Nucleo>,
        host: &mut dyn Host,
        stop: Stop,
        address: u64,
        bit: u32,
    ) {
        let access = |kind, address, value| {
            Access::new(kind, address, Width::W32, value).at(stop.instruction_count, stop.at)
        };
        let holds = match KEPT.contains(&address) {
            true => self.registers.read(address),
            false => session.access(access(AccessKind::Read, address, 0), host).0,
        };
        // A pin is changed by a write to the set and reset register, which the outside watches.
        let (address, value) = if PORTS.contains(&address) && address & 0x3ff == ODR {
            let was_high = holds >> bit & 1 == 1;
            (address + 4, 1 << (bit + if was_high { 16 } else { 0 }))
        } else {
            (address, holds ^ 1 << bit)
        };
        let write = access(AccessKind::Write, address, value);
        session.access(write, host);
        self.on_settled(
            session,
            host,
            Settled::Access {
                access: write,
                value,
            },
        );
    }

    /// A bit of the next frame from the input converter flips; 0 is the first on the line.
    pub(crate) fn turn_over_input(&mut self, session: &mut Session<Nucleo>, bit: u32) {
        self.chain.turn_over_input(session, bit);
    }

    /// A bit of the next command to the output converter flips; 0 is the last on the line.
    pub(crate) fn turn_over_output(&mut self, session: &mut Session<Nucleo>, bit: u32) {
        self.chain.turn_over_output(session, bit);
    }
}
