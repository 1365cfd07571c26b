//! The end of a program that cannot go on: PERMIT low before anything else, the DAC stays where it is, the reason is
//! kept, and the watchdog resets the chip.
//!
//! # Stack
//! The stack lies below all other memory (`memory.x`), so one that overflows runs into addresses that nobody may touch
//! (`stack_guard`), and that is a fault. The fault's handler cannot use such a stack; it takes the place of the oldest frames, to which
//! nobody will return.

use super::{kept, stack_guard};
use crate::board::this as board;
use crate::station::Heartbeats;
use core::arch::{asm, naked_asm};
use core::fmt::Write;
use core::sync::atomic::{AtomicPtr, Ordering::Relaxed};
use cortex_m::peripheral::SCB;
use heapless::String;
use link::status::{CrashCause, CrashReport};

/// Bytes at the end of the stack that a fault's frame and its floating-point registers need.
const FRAME: u32 = 104 + 8;

/// MMARVALID of the fault status: the address that the memory protection unit has refused is known.
const ADDRESS_IS_KNOWN: u32 = 1 << 7;

static HEARTBEATS: AtomicPtr<Heartbeats> = AtomicPtr::new(core::ptr::null_mut());

/// Where the control step's number can be read for a crash report.
pub fn note_heartbeats(heartbeats: &'static Heartbeats) {
    HEARTBEATS.store(core::ptr::from_ref(heartbeats).cast_mut(), Relaxed);
}

/// The control step's number.
pub fn noted_tick() -> u32 {
    // SAFETY: null or what `note_heartbeats` was given.
    unsafe { HEARTBEATS.load(Relaxed).as_ref() }.map_or(0, Heartbeats::tick)
}

/// PERMIT low, whoever owns the pin, in four instructions that read no memory and call nothing. Every way out begins with
/// them, before a word is put together: what ends the program may have damaged what that needs. Before the pins were set
/// up this writes to a port without a clock, and nothing happens.
macro_rules! drop_permit {
    () => {
        "movw r1, #{low}\nmovt r1, #{high}\nmov.w r2, #{reset}\nstr r2, [r1]\n"
    };
}

/// PERMIT's register in two halves, and what is written there.
const LOW: u32 = board::PERMIT_REGISTER & 0xffff;
const HIGH: u32 = board::PERMIT_REGISTER >> 16;
const RESET: u32 = board::PERMIT_RESET;

#[inline(always)]
fn drop_permit() {
    // SAFETY: a write to the port's register, which resets the one pin.
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

/// The end, with PERMIT low: the reason is kept, and the watchdog resets the chip.
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

/// The end by a panic. What does not fit of its message is cut.
#[inline(always)]
pub fn panicked(info: &core::panic::PanicInfo<'_>) -> ! {
    drop_permit();
    cortex_m::interrupt::disable();
    // A control step between the two has set it again.
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

/// Stack that is left for writing down a fault, at least: that takes some 900 bytes of it.
pub const ROOM_TO_TELL: u32 = 2048;

/// A fault of the processor: drops PERMIT, then finds a stack that can be used.
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

/// The fault, with the stack pointer as it was at its entry.
extern "C" fn faulted(frame: u32) -> ! {
    let end = (&raw const _stack_end).addr() as u32;
    // SAFETY: reading the fault status has no effect.
    let (status, at) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).mmfar.read()) };
    let mut text = Cut(String::new());
    let touched_guard = status & ADDRESS_IS_KNOWN != 0 && stack_guard::range().contains(&at);
    // The fault's own frame no longer fitted, or something was pushed below the end.
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

/// The supply is below what the chip needs. To be called first of all by the interrupt of its guard.
#[inline(always)]
pub fn supply_is_low() -> ! {
    drop_permit();
    halt(
        CrashCause::LowSupply,
        link::reply::cut("the supply fell below 2.9 V"),
    )
}
