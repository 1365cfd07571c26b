//! The memory array of the flash. The emulator's flash controller has the registers, with their locks and the duration of an
//! erase, but no array: a store into the flash is dropped, and nothing is erased. Here a word is programmed and a sector
//! erased, by RM0090 section 3.6 and table 48 of DS9405.
//!
//! Only the second bank can be programmed. A word stored while another one is being programmed, or into the bank that the program
//! runs from, stalls the chip; here it is lost, and reading it back shows that.

use rigless::device::Level;
use rigless::emulator::{Access, AccessKind, Checked, CoreBus, InterruptLine, Queued};
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use std::ops::Range;

/// Both banks.
const ARRAY: Range<u64> = 0x0800_0000..0x0820_0000;
const SECOND_BANK: Range<u64> = 0x0810_0000..0x0820_0000;

const SR: u64 = 0x4002_3c0c;
const CR: u64 = 0x4002_3c10;

// Bits of SR.
const EOP: u64 = 1;
const BSY: u64 = 1 << 16;

// Bits of CR.
const PG: u64 = 1;
const SER: u64 = 1 << 1;
const MASS: u64 = 1 << 2 | 1 << 15;
const SNB_SHIFT: u64 = 3;
const PSIZE: u64 = 3 << 8;
const PSIZE_WORD: u64 = 2 << 8;
const STRT: u64 = 1 << 16;
const EOPIE: u64 = 1 << 24;
const LOCK: u64 = 1 << 31;

/// `SNB` has this bit for a sector of the second bank.
const SNB_SECOND: u64 = 1 << 4;

/// Time to program a word, ns.
const WORD_NS: u64 = 16_000;

/// The flash's interrupt.
const INTERRUPT: u16 = 4;

/// Where this process has the chip's memory; the run has allocated it, and it outlives the processor.
#[derive(Debug, Default)]
pub(crate) struct Mapped(Vec<(Range<u64>, usize)>);

impl Mapped {
    /// Memory that the emulator has mapped.
    pub(crate) fn map(&mut self, range: Range<u64>, host: *mut u8) {
        self.0.push((range, host as usize));
    }

    fn place(&self, address: u64) -> Option<*mut u8> {
        let (range, host) = self.0.iter().find(|(range, _)| range.contains(&address))?;
        Some((host + (address - range.start) as usize) as *mut u8)
    }

    /// The value of a byte.
    pub(crate) fn byte(&self, address: u64) -> Option<u8> {
        // SAFETY: `map` was given this memory, and only the caller runs now.
        self.place(address).map(|place| unsafe { place.read() })
    }

    /// Changes a byte.
    pub(crate) fn put(&self, address: u64, byte: u8) {
        if let Some(place) = self.place(address) {
            // SAFETY: as above.
            unsafe { place.write(byte) };
        }
    }
}

/// The earlier of two events.
pub(crate) fn sooner(
    one: Option<VirtualNanos>,
    other: Option<VirtualNanos>,
) -> Option<VirtualNanos> {
    one.into_iter().chain(other).min()
}

/// The sector of the second bank with this number in `SNB`: four of 16 KiB, one of 64 and seven of 128.
fn sector(number: u64) -> Option<Range<u64>> {
    let (from, kib) = match number {
        0..=3 => (16 * number, 16),
        4 => (64, 64),
        5..=11 => (128 * (number - 4), 128),
        _ => return None,
    };
    let from = SECOND_BANK.start + from * 1024;
    Some(from..from + kib * 1024)
}

/// A word that is being programmed.
#[derive(Debug, Default)]
pub(crate) struct FlashArray {
    busy_until: Option<VirtualNanos>,
    /// Its end raises an interrupt.
    interrupts: bool,
    /// It has ended, and the flag has not been cleared.
    ended: bool,
    queued: Vec<Queued>,
    /// Ranges that have changed since the last call of `changed`.
    changed: Vec<Range<u64>>,
}

impl FlashArray {
    /// Resets the controller; the array keeps its contents.
    pub(crate) fn reset(&mut self) {
        *self = Self::default();
    }

    /// Takes the ranges that have changed since the last call.
    pub(crate) fn changed(&mut self) -> Vec<Range<u64>> {
        std::mem::take(&mut self.changed)
    }

    /// When the word will have been programmed.
    pub(crate) fn next_event(&self) -> Option<VirtualNanos> {
        self.busy_until
    }

    /// Ends the programming if that is due.
    pub(crate) fn on_event(&mut self, now: VirtualNanos) -> Option<Queued> {
        self.busy_until.take_if(|until| *until <= now)?;
        self.ended = self.interrupts;
        self.ended.then_some(line(Level::High)).flatten()
    }

    fn status(&self) -> u64 {
        let busy = if self.busy_until.is_some() { BSY } else { 0 };
        busy | if self.ended { EOP } else { 0 }
    }
}

fn line(level: Level) -> Option<Queued> {
    InterruptLine::new(INTERRUPT).map(|line| Queued::Line(line, level))
}

/// The processor's bus, with the array on it.
pub(crate) struct FlashBus<'a> {
    bus: &'a mut dyn CoreBus,
    flash: &'a mut FlashArray,
    memory: &'a Mapped,
}

impl<'a> FlashBus<'a> {
    pub(crate) fn new(
        bus: &'a mut dyn CoreBus,
        flash: &'a mut FlashArray,
        memory: &'a Mapped,
    ) -> Self {
        Self { bus, flash, memory }
    }

    /// The value of a register of the controller.
    fn register(&mut self, address: u64, now: &Access) -> u64 {
        let read = Access::new(AccessKind::Read, address, Width::W32, 0);
        let read = read.at(now.instruction_count, now.virtual_time);
        self.bus.access(read, false).unwrap_or(0)
    }

    /// A store into the second bank: bits can only be cleared.
    fn program(&mut self, access: &Access) {
        let control = self.register(CR, access);
        let busy = (self.register(SR, access) | self.flash.status()) & BSY != 0;
        let open = control & (LOCK | PG | PSIZE) == PG | PSIZE_WORD;
        let whole = access.width == Width::W32 && access.address.is_multiple_of(4);
        if busy || !open || !whole {
            return;
        }
        for (address, new) in (access.address..).zip((access.value as u32).to_le_bytes()) {
            let old = self.memory.byte(address).unwrap_or(0);
            self.memory.put(address, old & new);
        }
        self.changed(access.address..access.address + 4);
        self.flash.busy_until = Some(VirtualNanos(access.virtual_time.0 + WORD_NS));
        self.flash.interrupts = control & EOPIE != 0;
    }

    /// A write of the control register that has begun an erase; nothing reads the sector before it ends.
    fn erase(&mut self, control: u64) {
        let number = control >> SNB_SHIFT & 0x1f;
        let second = number & SNB_SECOND != 0;
        let erased = sector(number & !SNB_SECOND).filter(|_| second);
        if let Some(sector) = erased {
            for address in sector.clone() {
                self.memory.put(address, 0xff);
            }
            self.changed(sector);
        }
    }

    fn changed(&mut self, range: Range<u64>) {
        self.flash
            .queued
            .push(Queued::Invalidate(range.start, range.end));
    }
}

impl CoreBus for FlashBus<'_> {
    fn access(&mut self, access: Access, from_code: bool) -> Option<u64> {
        let write = access.kind == AccessKind::Write;
        let begins = write && access.address == CR && access.value & STRT != 0;
        let was_idle = begins && self.register(SR, &access) & BSY == 0;
        let answer = self.bus.access(access, from_code)?;
        match access.address {
            SR if write => {
                if access.value & EOP != 0 && std::mem::take(&mut self.flash.ended) {
                    self.flash.queued.extend(line(Level::Low));
                }
            }
            SR => return Some(answer | self.flash.status()),
            CR if was_idle && access.value & (SER | MASS) == SER => {
                if self.register(SR, &access) & BSY != 0 {
                    self.erase(access.value);
                }
            }
            address if write && SECOND_BANK.contains(&address) => self.program(&access),
            _ => {}
        }
        Some(answer)
    }

    fn queued(&mut self) -> Vec<Queued> {
        let mut queued = self.bus.queued();
        queued.append(&mut self.flash.queued);
        self.flash
            .changed
            .extend(queued.iter().filter_map(|queued| match queued {
                Queued::Invalidate(start, end) if ARRAY.contains(start) => Some(*start..*end),
                _ => None,
            }));
        queued
    }

    fn carry_on(&mut self, instructions: u64, event: Option<VirtualNanos>) -> Option<u32> {
        let event = sooner(event, self.flash.next_event());
        self.bus.carry_on(instructions, event)
    }

    // The rest is passed to the bus.

    fn time(&self, instructions: u64) -> VirtualNanos {
        self.bus.time(instructions)
    }

    fn acknowledge(&mut self, line: InterruptLine, instructions: u64) -> Option<u64> {
        self.bus.acknowledge(line, instructions)
    }

    fn read_checked(&mut self, access: Access, report: bool) -> Option<Checked> {
        self.bus.read_checked(access, report)
    }

    fn write_checked(&mut self, access: Access) -> Option<bool> {
        self.bus.write_checked(access)
    }

    fn stops_before(&mut self, access: &Access) -> bool {
        self.bus.stops_before(access)
    }

    fn send_trace(&mut self, bytes: &[u8]) {
        self.bus.send_trace(bytes);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_bank_is_twelve_sectors_without_a_gap() {
        let all: Vec<Range<u64>> = (0..32).filter_map(sector).collect();
        assert_eq!(all.len(), 12);
        assert!(all.windows(2).all(|two| two[0].end == two[1].start));
        assert_eq!(
            (all[0].start, all[11].end),
            (SECOND_BANK.start, SECOND_BANK.end)
        );
    }
}
