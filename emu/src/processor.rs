//! The processor of the emulator, with the flash array, and with access to its bits between two runs of instructions.

use crate::core_bits::{CoreBits, number};
use crate::cores::Cores;
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
        let inner = inner.clone();
        let cores = Cores::new(Box::new(move || inner(endian)))?;
        Ok(Box::new(Flashed {
            basepri: number(cores.now().target_xml(), "basepri"),
            cores,
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
    cores: Cores,
    bits: Option<CoreBits>,
    /// The debugger's number of BASEPRI.
    basepri: usize,
    memory: Mapped,
    flash: FlashArray,
}

impl Processor for Flashed {
    fn run(&mut self, budget: u32, bus: &mut dyn CoreBus) -> (Exit, u64) {
        if let Some(bits) = &self.bits {
            bits.before(&mut self.cores, &self.memory);
        }
        let mut bus = FlashBus::new(bus, &mut self.flash, &self.memory);
        let ran = self.cores.now_mut().run(budget, &mut bus);
        for range in self.flash.changed() {
            self.cores.changed(range);
        }
        if let Some(bits) = &self.bits {
            bits.behind(self.cores.now_mut(), self.basepri);
        }
        self.cores.after_a_stretch(&self.memory);
        ran
    }

    // The rest is passed to the processor.

    fn retired(&self) -> u64 {
        self.cores.now().retired()
    }

    fn ask(&mut self, queued: Queued) {
        self.cores.ask(queued);
    }

    fn maps(&self, start: u64, length: u64) -> bool {
        self.cores.now().maps(start, length)
    }

    fn page_size(&self) -> u64 {
        self.cores.now().page_size()
    }

    unsafe fn map(&mut self, start: u64, length: u64, host: *mut u8, writable: bool) {
        self.memory.map(start..start + length, host);
        // SAFETY: the caller's guarantee is passed on.
        unsafe { self.cores.map(start, length, host, writable) };
    }

    fn boot(&mut self, table: u64, read: &dyn Fn(u64, Width) -> Option<u64>) {
        self.cores.now_mut().boot(table, read);
    }

    fn reset(&mut self) {
        self.flash.reset();
        self.cores.reset();
    }

    fn take_reset_request(&mut self) -> bool {
        self.cores.now_mut().take_reset_request()
    }

    fn next_event(&self) -> Option<VirtualNanos> {
        sooner(self.cores.now().next_event(), self.flash.next_event())
    }

    fn on_event(&mut self, now: VirtualNanos) {
        if let Some(raised) = self.flash.on_event(now) {
            self.cores.ask(raised);
        }
        if self
            .cores
            .now_mut()
            .next_event()
            .is_some_and(|event| event <= now)
        {
            self.cores.now_mut().on_event(now);
        }
    }

    fn waiting(&self) -> bool {
        self.cores.now().waiting()
    }

    fn pc(&self) -> u64 {
        self.cores.now().pc()
    }

    fn add_breakpoint(&mut self, address: u64) -> bool {
        self.cores.add_breakpoint(address)
    }

    fn remove_breakpoint(&mut self, address: u64) {
        self.cores.remove_breakpoint(address);
    }

    fn pass_breakpoint(&mut self, address: u64) {
        self.cores.now_mut().pass_breakpoint(address);
    }

    fn attach_debugger(&mut self, attached: bool) {
        self.cores.each(|core| core.attach_debugger(attached));
    }

    fn hold_interrupts(&mut self, held: bool) {
        self.cores.each(|core| core.hold_interrupts(held));
    }

    fn gdb_register(&self, number: usize) -> Option<Vec<u8>> {
        self.cores.now().gdb_register(number)
    }

    fn set_gdb_register(&mut self, number: usize, bytes: &[u8]) -> bool {
        self.cores.now_mut().set_gdb_register(number, bytes)
    }

    fn debugger_access(
        &mut self,
        write: Option<u64>,
        address: u64,
        width: Width,
        now: VirtualNanos,
    ) -> Option<u64> {
        self.cores
            .now_mut()
            .debugger_access(write, address, width, now)
    }

    fn take_debugger_trace(&mut self) -> Vec<u8> {
        self.cores.now_mut().take_debugger_trace()
    }

    fn target_xml(&self) -> &'static str {
        self.cores.now().target_xml()
    }

    fn data_model(&self) -> DataModel {
        self.cores.now().data_model()
    }

    fn byte_order(&self, address: u64) -> Endian {
        self.cores.now().byte_order(address)
    }

    fn save(&self) -> Vec<u8> {
        self.cores.now().save()
    }

    fn load(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.cores.now_mut().load(bytes)
    }

    fn monitor_command(&mut self, command: &str) -> Option<String> {
        self.cores.now_mut().monitor_command(command)
    }

    fn debugger_halted(&mut self, why: HaltReason) -> bool {
        self.cores.now_mut().debugger_halted(why)
    }

    fn bit_alias(&self, address: u64, width: Width) -> Option<BitAlias> {
        self.cores.now().bit_alias(address, width)
    }

    fn own_ranges(&self) -> Vec<Range<u64>> {
        self.cores.now().own_ranges()
    }

    fn check_reads(&mut self, every: bool) {
        self.cores.each(|core| core.check_reads(every));
    }

    fn check_words(&mut self, words: &[u64]) {
        self.cores.each(|core| core.check_words(words));
    }

    fn host_call(&self, read: &mut dyn FnMut(u64, Width) -> Option<u64>) -> Option<HostCall> {
        self.cores.now().host_call(read)
    }

    fn answer_host_call(&mut self, answer: Option<u64>) {
        self.cores.now_mut().answer_host_call(answer);
    }
}
