//! The processor, with registers in which a bit can be turned over between two instructions.

use rigless::emulator::{
    BitAlias, CoreBus, CoreSpec, DataModel, Error, Exit, HaltReason, HostCall, Processor,
    ProcessorConstructor, Queued,
};
use rigless::soc::{Endian, Width};
use rigless::time::VirtualNanos;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Numbers by which GDB knows a register of this processor lie below this.
const NUMBERS: usize = 64;

/// A bit of the processor's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CoreBit {
    /// Of one of the registers that a program computes with, by a number that is taken modulo of what there is.
    Register(u32),
    /// Of a byte of the memory, the flash among it.
    Memory {
        /// The byte.
        address: u64,
        /// The bit.
        bit: u32,
    },
    /// Of a register of the processor's own peripherals: interrupts, memory protection.
    System {
        /// The register.
        address: u64,
        /// The bit.
        bit: u32,
        /// Now.
        at: VirtualNanos,
    },
}

/// Priorities of interrupts, a byte each (ARMv7-M, B3.4.9).
const PRIORITIES: u64 = 0xe000_e400;

#[derive(Debug, Default)]
struct Asked {
    turn: Option<CoreBit>,
    stack_pointer: u64,
    /// Interrupts whose priority is asked for, with what was found last.
    priorities: BTreeMap<u16, Option<u8>>,
    /// Every value of BASEPRI that was seen.
    masks: BTreeSet<u8>,
    /// Bytes among which one is sought, and what it holds now.
    sought: Vec<u64>,
    holds: Option<u8>,
}

/// What is asked of the processor, and what it tells. Clones are of the same processor.
#[derive(Clone, Debug, Default)]
pub struct CoreBits(Arc<Mutex<Asked>>);

impl CoreBits {
    fn asked(&self) -> MutexGuard<'_, Asked> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Turns a bit over before the next instruction.
    pub(crate) fn turn_over(&self, bit: CoreBit) {
        self.asked().turn = Some(bit);
    }

    /// Turns a bit of a byte of the memory over before the next instruction.
    pub fn turn_over_byte(&self, address: u64, bit: u32) {
        self.turn_over(CoreBit::Memory { address, bit });
    }

    /// Has a byte sought among these.
    pub fn seek(&self, ranges: impl IntoIterator<Item = Range<u64>>) {
        self.asked().sought = ranges.into_iter().flatten().collect();
    }

    /// Before the next instruction it holds this: others are no longer among them.
    pub fn holds(&self, byte: u8) {
        self.asked().holds = Some(byte);
    }

    /// What is left of them.
    pub fn sought(&self) -> Vec<u64> {
        self.asked().sought.clone()
    }

    /// Where the stack pointer is.
    pub(crate) fn stack_pointer(&self) -> u64 {
        self.asked().stack_pointer
    }

    /// Has the priorities of these interrupts looked at while the processor runs.
    pub fn look_at_priorities(&self, interrupts: &[u16]) {
        self.asked().priorities = interrupts.iter().map(|&i| (i, None)).collect();
    }

    /// The priorities as they were last, by interrupt.
    pub fn priorities(&self) -> BTreeMap<u16, Option<u8>> {
        self.asked().priorities.clone()
    }

    /// What critical sections have masked so far: the values of BASEPRI between two stretches of instructions.
    pub fn masks(&self) -> BTreeSet<u8> {
        self.asked().masks.clone()
    }

    /// The core with its processor behind these.
    pub(crate) fn before(&self, mut core: CoreSpec) -> CoreSpec {
        let (inner, bits) = (core.processor, self.clone());
        let processor: ProcessorConstructor = Arc::new(move |endian| {
            let inner = inner(endian)?;
            Ok(Box::new(Turned {
                basepri: number(inner.target_xml(), "basepri"),
                inner,
                bits: bits.clone(),
                mapped: Vec::new(),
            }) as Box<dyn Processor>)
        });
        core.processor = processor;
        core
    }
}

/// A processor, and what is asked of it.
#[derive(Debug)]
struct Turned {
    inner: Box<dyn Processor>,
    bits: CoreBits,
    /// The debugger's number of that register.
    basepri: usize,
    /// Addresses of the memory, and where this process has it.
    mapped: Vec<(Range<u64>, usize)>,
}

/// The debugger's number of a register: they count on from the last one whose number is said.
fn number(xml: &str, name: &str) -> usize {
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

impl Turned {
    fn turn_over(&mut self, bit: CoreBit) {
        match bit {
            CoreBit::Register(place) => {
                let all: Vec<(usize, Vec<u8>)> = (0..NUMBERS)
                    .filter_map(|number| Some((number, self.inner.gdb_register(number)?)))
                    .collect();
                let bits: usize = all.iter().map(|(_, bytes)| 8 * bytes.len()).sum();
                let mut place = place as usize % bits.max(1);
                for (number, mut bytes) in all {
                    if let Some(byte) = bytes.get_mut(place / 8) {
                        *byte ^= 1 << (place % 8);
                        self.inner.set_gdb_register(number, &bytes);
                        return;
                    }
                    place -= 8 * bytes.len();
                }
            }
            CoreBit::Memory { address, bit } => self.turn_over_memory(address, bit),
            CoreBit::System { address, bit, at } => {
                let mut access = |write| self.inner.debugger_access(write, address, Width::W32, at);
                if let Some(value) = access(None) {
                    access(Some(value ^ 1 << bit));
                }
            }
        }
    }
}

impl Turned {
    /// The emulator itself writes no flash of this chip.
    fn turn_over_memory(&mut self, address: u64, bit: u32) {
        let byte = self.byte(address);
        // SAFETY: as `byte` says; nothing runs now.
        unsafe { *byte ^= 1 << bit };
        self.inner.ask(Queued::Invalidate(address, address + 1));
    }

    /// A byte of the memory: `map` was given it, the run has allocated it, and it outlives the processor.
    fn byte(&self, address: u64) -> *mut u8 {
        let mut mapped = self.mapped.iter();
        let place = mapped.find(|(range, _)| range.contains(&address));
        let (range, host) = place.expect("there is memory at the address");
        (host + (address - range.start) as usize) as *mut u8
    }

    /// Of the bytes that are sought those stay that hold this.
    fn keep(&self, holds: u8) {
        let mut sought = std::mem::take(&mut self.bits.asked().sought);
        // SAFETY: as `byte` says; nothing runs now.
        sought.retain(|address| unsafe { *self.byte(*address) } == holds);
        self.bits.asked().sought = sought;
    }
}

impl Processor for Turned {
    fn run(&mut self, budget: u32, bus: &mut dyn CoreBus) -> (Exit, u64) {
        let turn = self.bits.asked().turn.take();
        if let Some(bit) = turn {
            self.turn_over(bit);
        }
        let holds = self.bits.asked().holds.take();
        if let Some(holds) = holds {
            self.keep(holds);
        }
        let ran = self.inner.run(budget, bus);
        let pointer = self.inner.gdb_register(13);
        let pointer = pointer.and_then(|bytes| Some(u32::from_le_bytes(bytes.try_into().ok()?)));
        let mask = self.inner.gdb_register(self.basepri);
        let bits = self.bits.clone();
        let mut asked = bits.asked();
        asked.stack_pointer = pointer.unwrap_or(0).into();
        asked
            .masks
            .extend(mask.and_then(|bytes| bytes.first().copied()));
        for (interrupt, priority) in &mut asked.priorities {
            let address = PRIORITIES + u64::from(*interrupt);
            let word = address & !3;
            let held = self
                .inner
                .debugger_access(None, word, Width::W32, VirtualNanos(0));
            *priority = held.map(|held| (held >> (8 * (address - word))) as u8);
        }
        ran
    }

    // What follows is the processor's.

    fn retired(&self) -> u64 {
        self.inner.retired()
    }

    fn ask(&mut self, queued: Queued) {
        self.inner.ask(queued);
    }

    fn maps(&self, start: u64, length: u64) -> bool {
        self.inner.maps(start, length)
    }

    fn page_size(&self) -> u64 {
        self.inner.page_size()
    }

    unsafe fn map(&mut self, start: u64, length: u64, host: *mut u8, writable: bool) {
        self.mapped.push((start..start + length, host as usize));
        // SAFETY: what the caller promises is promised on.
        unsafe { self.inner.map(start, length, host, writable) };
    }

    fn boot(&mut self, table: u64, read: &dyn Fn(u64, Width) -> Option<u64>) {
        self.inner.boot(table, read);
    }

    fn reset(&mut self) {
        self.inner.reset();
    }

    fn take_reset_request(&mut self) -> bool {
        self.inner.take_reset_request()
    }

    fn next_event(&self) -> Option<VirtualNanos> {
        self.inner.next_event()
    }

    fn on_event(&mut self, now: VirtualNanos) {
        self.inner.on_event(now);
    }

    fn waiting(&self) -> bool {
        self.inner.waiting()
    }

    fn pc(&self) -> u64 {
        self.inner.pc()
    }

    fn add_breakpoint(&mut self, address: u64) -> bool {
        self.inner.add_breakpoint(address)
    }

    fn remove_breakpoint(&mut self, address: u64) {
        self.inner.remove_breakpoint(address);
    }

    fn pass_breakpoint(&mut self, address: u64) {
        self.inner.pass_breakpoint(address);
    }

    fn attach_debugger(&mut self, attached: bool) {
        self.inner.attach_debugger(attached);
    }

    fn hold_interrupts(&mut self, held: bool) {
        self.inner.hold_interrupts(held);
    }

    fn gdb_register(&self, number: usize) -> Option<Vec<u8>> {
        self.inner.gdb_register(number)
    }

    fn set_gdb_register(&mut self, number: usize, bytes: &[u8]) -> bool {
        self.inner.set_gdb_register(number, bytes)
    }

    fn debugger_access(
        &mut self,
        write: Option<u64>,
        address: u64,
        width: Width,
        now: VirtualNanos,
    ) -> Option<u64> {
        self.inner.debugger_access(write, address, width, now)
    }

    fn take_debugger_trace(&mut self) -> Vec<u8> {
        self.inner.take_debugger_trace()
    }

    fn target_xml(&self) -> &'static str {
        self.inner.target_xml()
    }

    fn data_model(&self) -> DataModel {
        self.inner.data_model()
    }

    fn byte_order(&self, address: u64) -> Endian {
        self.inner.byte_order(address)
    }

    fn save(&self) -> Vec<u8> {
        self.inner.save()
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.inner.load(bytes)
    }

    fn monitor_command(&mut self, command: &str) -> Option<String> {
        self.inner.monitor_command(command)
    }

    fn debugger_halted(&mut self, why: HaltReason) -> bool {
        self.inner.debugger_halted(why)
    }

    fn bit_alias(&self, address: u64, width: Width) -> Option<BitAlias> {
        self.inner.bit_alias(address, width)
    }

    fn own_ranges(&self) -> Vec<Range<u64>> {
        self.inner.own_ranges()
    }

    fn check_reads(&mut self, every: bool) {
        self.inner.check_reads(every);
    }

    fn check_words(&mut self, words: &[u64]) {
        self.inner.check_words(words);
    }

    fn host_call(&self, read: &mut dyn FnMut(u64, Width) -> Option<u64>) -> Option<HostCall> {
        self.inner.host_call(read)
    }

    fn answer_host_call(&mut self, answer: Option<u64>) {
        self.inner.answer_host_call(answer);
    }
}
