//! Faults on demand, to see on the very image that runs a test that each ends safely.
//!
//! A debugger, or the emulator, writes [`MAGIC`] and a number into [`DRILL`]; nothing on the link can, and a stray write of
//! a small number does nothing. The background task looks at it
//! ten times a second, the control interrupt in every step.

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::{DWT, SCB};
use embassy_stm32::interrupt;
use embassy_stm32::interrupt::InterruptExt;

/// The drill that is asked for; its symbol is `DRILL`.
#[unsafe(no_mangle)]
pub static DRILL: AtomicU32 = AtomicU32::new(0);

/// Added to a drill's number.
pub const MAGIC: u32 = 0x4452_4c00;

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drill {
    /// None.
    None = 0,
    /// A panic.
    Panic = 1,
    /// An undefined instruction.
    HardFault = 2,
    /// A recursion without end.
    Stack = 3,
    /// A task that never gives up the processor.
    Starve = 4,
    /// Interrupts off, for good.
    Hang = 5,
    /// One step that takes too long.
    Overrun = 6,
    /// The external clock's guard.
    ClockStopped = 7,
    /// The supply's guard.
    LowSupply = 8,
}

/// NMIPENDSET of the interrupt control and state register.
const NMI_PENDING: u32 = 1 << 31;

/// Cycles of an overrun: 300 us.
const OVERRUN_CYCLES: u32 = 50_400;

/// What is asked for.
#[inline]
pub fn asked() -> Drill {
    match DRILL.load(Relaxed).wrapping_sub(MAGIC) {
        1 => Drill::Panic,
        2 => Drill::HardFault,
        3 => Drill::Stack,
        4 => Drill::Starve,
        5 => Drill::Hang,
        6 => Drill::Overrun,
        7 => Drill::ClockStopped,
        8 => Drill::LowSupply,
        _ => Drill::None,
    }
}

/// Carries out what the background has to.
pub fn background() {
    match asked() {
        Drill::None | Drill::Overrun => {}
        Drill::ClockStopped => {
            // SAFETY: pends the exception, as the clock's guard does.
            unsafe { (*SCB::PTR).icsr.write(NMI_PENDING) };
        }
        Drill::LowSupply => interrupt::PVD.pend(),
        Drill::Panic => panic!("a drill"),
        Drill::HardFault => cortex_m::asm::udf(),
        Drill::Stack => {
            black_box(deeper(1));
        }
        Drill::Starve => loop {
            cortex_m::asm::nop();
        },
        Drill::Hang => {
            cortex_m::interrupt::disable();
            loop {
                cortex_m::asm::nop();
            }
        }
    }
}

/// Holds one step up.
#[cold]
pub fn overrun() {
    DRILL.store(Drill::None as u32, Relaxed);
    let begin = DWT::cycle_count();
    while DWT::cycle_count().wrapping_sub(begin) < OVERRUN_CYCLES {}
}

#[inline(never)]
fn deeper(depth: u32) -> u32 {
    // 18 words: with 16, frames of 80 bytes, the emulated chip passed the end of one image's stack unseen; why is not known.
    let mut room = [depth; 18];
    black_box(&mut room);
    let below = if black_box(true) {
        deeper(depth + 1)
    } else {
        0
    };
    below + room.iter().sum::<u32>()
}
