//! The processor of the emulator, with the flash array, and with access to its bits between two runs of instructions.

use crate::core_bits::{CoreBits, number};
use crate::flash::{FlashArray, FlashBus, Mapped, sooner};
use rigless::emulator::{
    BitAlias, CoreBus, CoreSpec, DataModel, Error, Exit, HaltReason, HostCall, Processor,
    ProcessorConstructor, Queued,
};
use rigless::soc::{Endian, Width};
use rigless::time::VirtualNanos;
use std::ops::Range;
use std::sync::Arc;

/// The core, with [`Flashed`] in place of its processor.
pub(crate) fn with_flash(mut core: CoreSpec, bits: Option<CoreBits>) -> CoreSpec {
    let inner = core.processor;
    let processor: ProcessorConstructor = Arc::new(move |endian| {
        let inner = inner(endian)?;
        Ok(Box::new(Flashed {
            basepri: number(inner.target_xml(), "basepri"),
            inner,
            bits: bits.clone(),
            memory: Mapped::default(),
            flash: FlashArray::default(),
        }) as Box<dyn Processor>)
    });
    core.processor = processor;
    core
}

/// A processor with the flash array and access to its bits.
#[derive(Debug)]
struct Flashed {
    inner: Box<dyn Processor>,
    bits: Option<CoreBits>,
    /// The debugger's number of BASEPRI.
    basepri: usize,
    memory: Mapped,
    flash: FlashArray,
}

impl Processor for Flashed {
    fn run(&mut self, budget: u32, bus: &mut dyn CoreBus) -> (Exit, u64) {
        if let Some(bits) = &self.bits {
            bits.before(self.inner.as_mut(), &self.memory);
        }
        let mut bus = FlashBus::new(bus, &mut self.flash, &self.memory);
        let ran = self.inner.run(budget, &mut bus);
        if let Some(bits) = &self.bits {
            bits.behind(self.inner.as_mut(), self.basepri);
        }
        ran
    }

    // The rest is passed to the processor.

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
        self.memory.map(start..start + length, host);
        // SAFETY: the caller's guarantee is passed on.
        unsafe { self.inner.map(start, length, host, writable) };
    }

    fn boot(&mut self, table: u64, read: &dyn Fn(u64, Width) -> Option<u64>) {
        self.inner.boot(table, read);
    }

    fn reset(&mut self) {
        self.flash.reset();
        self.inner.reset();
    }

    fn take_reset_request(&mut self) -> bool {
        self.inner.take_reset_request()
    }

    fn next_event(&self) -> Option<VirtualNanos> {
        sooner(self.inner.next_event(), self.flash.next_event())
    }

    fn on_event(&mut self, now: VirtualNanos) {
        if let Some(raised) = self.flash.on_event(now) {
            self.inner.ask(raised);
        }
        if self.inner.next_event().is_some_and(|event| event <= now) {
            self.inner.on_event(now);
        }
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
