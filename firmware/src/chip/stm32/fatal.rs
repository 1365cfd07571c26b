//! The end of a program that cannot go on: PERMIT low before anything else, the DAC stays where it is, the reason is
//! kept, and the watchdog resets the chip.
//!
//! # Stack
//! The stack lies below all other memory (`memory.x`), so an overflow runs into forbidden addresses (`stack_guard`),
//! which is a fault. The fault's handler cannot use such a stack; it overwrites the oldest frames, to which nothing
//! will return.

use super::{kept, stack_guard};
use crate::board::this as board;
use crate::station::Heartbeats;
use core::arch::{asm, naked_asm};
use core::fmt::Write;
use core::sync::atomic::{AtomicPtr, Ordering::Relaxed};
use cortex_m::peripheral::SCB;
use heapless::String;
use link::status::{CrashCause, CrashReport};

/// Bytes needed at the end of the stack for a fault's frame and its floating-point registers.
const FRAME: u32 = 104 + 8;

/// MMARVALID of the fault status: the address refused by the memory protection unit is known.
const ADDRESS_IS_KNOWN: u32 = 1 << 7;

static HEARTBEATS: AtomicPtr<Heartbeats> = AtomicPtr::new(core::ptr::null_mut());

/// Makes the control step's number available to a crash report.
pub fn note_heartbeats(heartbeats: &'static Heartbeats) {
    HEARTBEATS.store(core::ptr::from_ref(heartbeats).cast_mut(), Relaxed);
}

/// The control step's number.
pub fn noted_tick() -> u32 {
    // SAFETY: null or the argument of `note_heartbeats`.
    unsafe { HEARTBEATS.load(Relaxed).as_ref() }.map_or(0, Heartbeats::tick)
}

/// PERMIT low, whoever owns the pin, in four instructions that read no memory and call nothing. Every way out starts
/// with them, before it composes a message: the cause of the end may have damaged what that needs. Before the pins are
/// set up this writes to a port without a clock, and nothing happens.
macro_rules! drop_permit {
    () => {
        "movw r1, #{low}\nmovt r1, #{high}\nmov.w r2, #{reset}\nstr r2, [r1]\n"
    };
}

/// PERMIT's register in two halves, and the value to write.
const LOW: u32 = board::PERMIT_REGISTER & 0xffff;
const HIGH: u32 = board::PERMIT_REGISTER >> 16;
const RESET: u32 = board::PERMIT_RESET;

#[inline(always)]
fn drop_permit() {
    // SAFETY: a write to the port's register, which resets this one pin.
    unsafe {
        asm!(
            drop_permit!(),
            low = const LOW,
            high = const HIGH,
            reset = const RESET,
            out("r1") _,
            out("r2") _,
            options(nostack, preserves_flags),
        );
    };
}

/// The end, with PERMIT low: keeps the reason, and lets the watchdog reset the chip.
fn halt(cause: CrashCause, text: String<96>) -> ! {
    cortex_m::interrupt::disable();
    board::fault_lamp_on();
    kept::keep(&CrashReport {
        cause,
        tick: noted_tick(),
        mode: kept::noted_mode(),
        text,
    });
    loop {
        cortex_m::asm::nop();
    }
}

/// The end by a panic. Its message is truncated to fit.
#[inline(always)]
pub fn panicked(info: &core::panic::PanicInfo<'_>) -> ! {
    drop_permit();
    cortex_m::interrupt::disable();
    // A control step in between may have set it again.
    drop_permit();
    write_panic(info)
}

#[inline(never)]
fn write_panic(info: &core::panic::PanicInfo<'_>) -> ! {
    let mut text = Cut(String::new());
    if let Some(at) = info.location() {
        let file = at.file().rsplit('/').next().unwrap_or_default();
        let _ = write!(text, "{file}:{} ", at.line());
    }
    let _ = write!(text, "{}", info.message());
    halt(CrashCause::Panic, text.0)
}

/// A text, truncated to fit.
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
    /// End of the stack, from `memory.x`.
    static _stack_end: u32;
}

/// Least stack left for recording a fault, which takes some 900 bytes.
pub const ROOM_TO_TELL: u32 = 2048;

/// A fault of the processor: drops PERMIT, then finds a usable stack.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn HardFault() -> ! {
    naked_asm!(
        drop_permit!(),
        "mrs r0, msp",
        "ldr r1, =_stack_end",
        "add r1, r1, {room}",
        "cmp r0, r1",
        "bhs 1f",
        "ldr r2, =_stack_start",
        "msr msp, r2",
        "1: b {faulted}",
        low = const LOW,
        high = const HIGH,
        reset = const RESET,
        room = const ROOM_TO_TELL,
        faulted = sym faulted,
    )
}

/// The fault, with the stack pointer at its entry.
extern "C" fn faulted(frame: u32) -> ! {
    let end = (&raw const _stack_end).addr() as u32;
    // SAFETY: reading the fault status has no effect.
    let (status, at) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).mmfar.read()) };
    let mut text = Cut(String::new());
    let touched_guard = status & ADDRESS_IS_KNOWN != 0 && stack_guard::range().contains(&at);
    // The fault's own frame did not fit, or something was pushed below the end.
    if frame < end + FRAME || touched_guard {
        let _ = write!(
            text,
            "the stack grew beyond {end:#010x}, CFSR {status:#010x}"
        );
        halt(CrashCause::StackOverflow, text.0)
    }
    // SAFETY: the frame lies in the stack; its seventh word is the program counter.
    let pc = unsafe { (frame as *const u32).add(6).read_volatile() };
    let _ = write!(text, "pc {pc:#010x}, CFSR {status:#010x}");
    halt(CrashCause::HardFault, text.0)
}

/// The external clock has stopped.
#[cortex_m_rt::exception]
unsafe fn NonMaskableInt() -> ! {
    drop_permit();
    halt(
        CrashCause::ClockStopped,
        link::reply::cut("the external clock stopped"),
    )
}

/// The supply is below the chip's requirement. The interrupt of its guard must call this first.
#[inline(always)]
pub fn supply_is_low() -> ! {
    drop_permit();
    halt(
        CrashCause::LowSupply,
        link::reply::cut("the supply fell below 2.9 V"),
    )
}
