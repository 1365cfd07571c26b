//! The end of a program that cannot go on: PERMIT low, the DAC stays where it is, the reason is kept, and the watchdog
//! resets the chip.
//!
//! # Stack
//! The stack lies below all other memory (`memory.x`), so one that overflows runs into addresses where nothing is, and
//! that is a bus fault. The fault's handler cannot use such a stack; it takes the place of the oldest frames, to which
//! nobody will return.

use super::kept;
use crate::station::Evidence;
use core::arch::naked_asm;
use core::fmt::Write;
use core::sync::atomic::{AtomicPtr, Ordering::Relaxed};
use cortex_m::peripheral::SCB;
use embassy_stm32::pac;
use heapless::String;
use link::status::{Cause, LastWords};

/// Bytes at the end of the stack that a fault's frame and its floating-point registers need.
const FRAME: u32 = 104 + 8;

static EVIDENCE: AtomicPtr<Evidence> = AtomicPtr::new(core::ptr::null_mut());

/// Where the control step's number can be read for last words.
pub fn note_evidence(evidence: &'static Evidence) {
    EVIDENCE.store(core::ptr::from_ref(evidence).cast_mut(), Relaxed);
}

/// The end.
pub fn die(cause: Cause, text: String<96>) -> ! {
    cortex_m::interrupt::disable();
    // PERMIT, whoever owns the pin. Before the pins were set up this writes to a port without a clock: nothing happens.
    pac::GPIOE.bsrr().write(|w| w.set_br(9, true));
    pac::GPIOB.bsrr().write(|w| w.set_bs(14, true));
    // SAFETY: null or what `note_evidence` was given.
    let tick = unsafe { EVIDENCE.load(Relaxed).as_ref() }.map_or(0, Evidence::tick);
    kept::keep(&LastWords {
        cause,
        tick,
        state: kept::noted_state(),
        text,
    });
    loop {
        cortex_m::asm::nop();
    }
}

/// The end by a panic. What does not fit of its message is cut.
pub fn panicked(info: &core::panic::PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    let mut text = Cut(String::new());
    if let Some(at) = info.location() {
        let file = at.file().rsplit('/').next().unwrap_or_default();
        let _ = write!(text, "{file}:{} ", at.line());
    }
    let _ = write!(text, "{}", info.message());
    die(Cause::Panic, text.0)
}

/// As much of a text as fits.
struct Cut(String<96>);

impl Write for Cut {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        for c in text.chars() {
            self.0.push(c).map_err(|_| core::fmt::Error)?;
        }
        Ok(())
    }
}

unsafe extern "C" {
    /// End of the stack, by `memory.x`.
    static _stack_end: u32;
}

/// A fault of the processor: finds a stack that can be used.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!(
        "mrs r0, msp",
        "ldr r1, =_stack_end",
        "add r1, r1, {room}",
        "cmp r0, r1",
        "bhs 1f",
        "ldr r2, =_stack_start",
        "msr msp, r2",
        "1: b {faulted}",
        room = const 512,
        faulted = sym faulted,
    )
}

/// The fault, with the stack pointer as it was at its entry.
extern "C" fn faulted(frame: u32) -> ! {
    let end = (&raw const _stack_end).addr() as u32;
    // SAFETY: reading the fault status has no effect.
    let (status, at) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).bfar.read()) };
    let mut text = Cut(String::new());
    // The fault's own frame no longer fitted, or something was pushed below the end.
    if frame < end + FRAME || (at < end && at >= end.wrapping_sub(4096)) {
        let _ = write!(text, "the stack grew beyond {end:#010x}");
        die(Cause::StackOverflow, text.0)
    }
    // SAFETY: the frame lies in the stack; its seventh word is the program counter.
    let pc = unsafe { (frame as *const u32).add(6).read_volatile() };
    let _ = write!(text, "pc {pc:#010x}, CFSR {status:#010x}");
    die(Cause::HardFault, text.0)
}

/// The external clock has stopped.
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() -> ! {
    die(
        Cause::HardFault,
        link::reply::cut("the external clock stopped"),
    )
}
