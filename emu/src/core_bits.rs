//! Access to the processor between two runs of instructions: flips a bit, reads registers.

use crate::cores::Cores;
use crate::flash::Mapped;
use rigless::emulator::{Processor, Queued};
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// GDB's register numbers of this processor are below this.
const NUMBERS: usize = 64;

/// A bit of the processor or its memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CoreBit {
    /// A bit of a core register, by a number modulo the number of bits of all of them.
    Register(u32),
    /// A bit of a byte of memory, including the flash.
    Memory {
        /// The byte.
        address: u64,
        /// The bit.
        bit: u32,
    },
    /// A bit of a register of the processor's own peripherals (interrupts, memory protection).
    System {
        /// The register.
        address: u64,
        /// The bit.
        bit: u32,
        /// Now.
        at: VirtualNanos,
    },
}

#[derive(Debug, Default)]
struct Asked {
    turn: Option<CoreBit>,
    stack_pointer: u64,
    /// Registers of the processor's own peripherals that are watched, with their last values.
    system: BTreeMap<u64, Option<u64>>,
    /// Every value of BASEPRI seen.
    masks: BTreeSet<u8>,
    /// Candidate addresses of a byte that is sought, and the value that it holds now.
    sought: Vec<u64>,
    holds: Option<u8>,
}

/// Requests to the processor, and its answers. Clones refer to the same processor.
#[derive(Clone, Debug, Default)]
pub struct CoreBits(Arc<Mutex<Asked>>);

impl CoreBits {
    fn asked(&self) -> MutexGuard<'_, Asked> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Flips a bit before the next instruction.
    pub(crate) fn turn_over(&self, bit: CoreBit) {
        self.asked().turn = Some(bit);
    }

    /// Flips a bit of r0 to r15 (the program counter) before the next instruction.
    pub fn turn_over_register(&self, number: u32, bit: u32) {
        self.turn_over(CoreBit::Register(32 * number + bit));
    }

    /// Flips a bit of a byte of memory before the next instruction.
    pub fn turn_over_byte(&self, address: u64, bit: u32) {
        self.turn_over(CoreBit::Memory { address, bit });
    }

    /// Flips a bit of a register of the processor's own peripherals before the next instruction; not for a counter.
    pub fn turn_over_system(&self, address: u64, bit: u32) {
        let at = VirtualNanos(0);
        self.turn_over(CoreBit::System { address, bit, at });
    }

    /// Starts a search for a byte among these addresses.
    pub fn seek(&self, ranges: impl IntoIterator<Item = Range<u64>>) {
        self.asked().sought = ranges.into_iter().flatten().collect();
    }

    /// Keeps only the addresses that hold this value before the next instruction.
    pub fn holds(&self, byte: u8) {
        self.asked().holds = Some(byte);
    }

    /// The addresses that remain.
    pub fn sought(&self) -> Vec<u64> {
        self.asked().sought.clone()
    }

    /// The stack pointer.
    pub(crate) fn stack_pointer(&self) -> u64 {
        self.asked().stack_pointer
    }

    /// Watches these registers of the processor's own peripherals while it runs.
    pub fn look_at(&self, registers: impl IntoIterator<Item = u64>) {
        self.asked().system = registers.into_iter().map(|at| (at, None)).collect();
    }

    /// The last value of one of them.
    pub fn found(&self, register: u64) -> Option<u64> {
        self.asked().system.get(&register).copied().flatten()
    }

    /// What critical sections have masked so far: the values of BASEPRI between two runs of instructions.
    pub fn masks(&self) -> BTreeSet<u8> {
        self.asked().masks.clone()
    }

    /// Before a run of instructions.
    pub(crate) fn before(&self, cores: &mut Cores, memory: &Mapped) {
        let turn = self.asked().turn.take();
        if let Some(bit) = turn {
            turn_over(bit, cores, memory);
        }
        let asked = &mut *self.asked();
        if let Some(holds) = asked.holds.take() {
            let there = |address: &u64| memory.byte(*address) == Some(holds);
            asked.sought.retain(there);
        }
    }

    /// After it, with the debugger's number of BASEPRI.
    pub(crate) fn behind(&self, processor: &mut dyn Processor, basepri: usize) {
        let pointer = processor.gdb_register(13);
        let pointer = pointer.and_then(|bytes| Some(u32::from_le_bytes(bytes.try_into().ok()?)));
        let mask = processor.gdb_register(basepri);
        let mut asked = self.asked();
        asked.stack_pointer = pointer.unwrap_or(0).into();
        asked
            .masks
            .extend(mask.and_then(|bytes| bytes.first().copied()));
        for (register, found) in &mut asked.system {
            *found = processor.debugger_access(None, *register, Width::W32, VirtualNanos(0));
        }
    }
}

/// The debugger's number of a register; numbers continue from the last one given explicitly.
pub(crate) fn number(xml: &str, name: &str) -> usize {
    let mut number = 0;
    for register in xml.split("<reg ").skip(1) {
        let attribute = |key: &str| register.split_once(key)?.1.split('"').next();
        let register = register.split('>').next().unwrap_or(register);
        if let Some(said) = register
            .contains("regnum=")
            .then(|| attribute("regnum=\"")?.parse().ok())
            .flatten()
        {
            number = said;
        }
        if attribute("name=\"") == Some(name) {
            return number;
        }
        number += 1;
    }
    panic!("the processor has no register {name}")
}

fn turn_over(bit: CoreBit, cores: &mut Cores, memory: &Mapped) {
    match bit {
        CoreBit::Register(place) => {
            let processor = cores.now_mut();
            let all: Vec<(usize, Vec<u8>)> = (0..NUMBERS)
                .filter_map(|number| Some((number, processor.gdb_register(number)?)))
                .collect();
            let bits: usize = all.iter().map(|(_, bytes)| 8 * bytes.len()).sum();
            let mut place = place as usize % bits.max(1);
            for (number, mut bytes) in all {
                if let Some(byte) = bytes.get_mut(place / 8) {
                    *byte ^= 1 << (place % 8);
                    processor.set_gdb_register(number, &bytes);
                    return;
                }
                place -= 8 * bytes.len();
            }
        }
        CoreBit::Memory { address, bit } => {
            let byte = memory.byte(address).expect("there is memory at it");
            memory.put(address, byte ^ 1 << bit);
            cores.ask(Queued::Invalidate(address, address + 1));
        }
        CoreBit::System { address, bit, at } => {
            let processor = cores.now_mut();
            let mut access = |write| processor.debugger_access(write, address, Width::W32, at);
            if let Some(value) = access(None) {
                access(Some(value ^ 1 << bit));
            }
        }
    }
}
