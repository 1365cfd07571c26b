//! Faults on demand, to verify that each ends safely on the very image that runs a test.
//!
//! A debugger, or the emulator, writes [`MAGIC`] and a number into [`DRILL`]; nothing on the link can, and a stray
//! write of a small number has no effect. The background task checks it ten times a second, the control interrupt in
//! every step.

use crate::chip::this::supply;
use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::{DWT, SCB};

/// The requested drill; its symbol is `DRILL`.
#[unsafe(no_mangle)]
pub static DRILL: AtomicU32 = AtomicU32::new(0);

/// Added to a drill's number.
pub const MAGIC: u32 = 0x4452_4c00;

/// First number of the stack drills, which differ by the start of their recursion.
const FIRST_STACK: u32 = 0x30;
const LAST_STACK: u32 = 0x3f;

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Drill {
    /// None.
    None,
    /// A panic.
    Panic,
    /// An undefined instruction.
    HardFault,
    /// An endless recursion.
    Stack {
        /// Multiples of eight bytes by which it starts lower.
        eights: u32,
    },
    /// A task that never gives up the processor.
    Starve,
    /// Interrupts off, forever.
    Hang,
    /// One step that takes too long.
    Overrun,
    /// The external clock's guard.
    ClockStopped,
    /// The supply's guard.
    LowSupply,
}

/// NMIPENDSET of the interrupt control and state register.
const NMI_PENDING: u32 = 1 << 31;

/// Cycles of an overrun: 300 us.
const OVERRUN_CYCLES: u32 = 50_400;

/// The requested drill.
#[inline]
pub fn asked() -> Drill {
    match DRILL.load(Relaxed).wrapping_sub(MAGIC) {
        1 => Drill::Panic,
        2 => Drill::HardFault,
        3 => Drill::Stack { eights: 0 },
        4 => Drill::Starve,
        5 => Drill::Hang,
        6 => Drill::Overrun,
        7 => Drill::ClockStopped,
        8 => Drill::LowSupply,
        number @ FIRST_STACK..=LAST_STACK => Drill::Stack {
            eights: number - FIRST_STACK,
        },
        _ => Drill::None,
    }
}

/// Carries out the drills of the background.
pub fn background() {
    match asked() {
        Drill::None | Drill::Overrun => {}
        Drill::ClockStopped => {
            // SAFETY: pends the exception, as the clock's guard does.
            unsafe { (*SCB::PTR).icsr.write(NMI_PENDING) };
        }
        Drill::LowSupply => supply::pend(),
        Drill::Panic => panic!("a drill"),
        Drill::HardFault => cortex_m::asm::udf(),
        Drill::Stack { eights } => {
            black_box(lower(eights));
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

/// Delays one step.
#[cold]
pub fn overrun() {
    DRILL.store(0, Relaxed);
    let begin = DWT::cycle_count();
    while DWT::cycle_count().wrapping_sub(begin) < OVERRUN_CYCLES {}
}

/// Starts the recursion a multiple of eight bytes lower, so that one drill hits each frame position at the stack's end.
#[inline(never)]
fn lower(eights: u32) -> u32 {
    match eights {
        0 => use_stack(1),
        _ => black_box(lower(eights - 1)),
    }
}

/// Endless as long as the drill is requested. The request is in a static: data on a stack that has left the memory
/// decide nothing.
#[inline(never)]
fn use_stack(depth: u32) -> u32 {
    let mut room = [depth; 16];
    black_box(&mut room);
    let below = match asked() {
        Drill::Stack { .. } => use_stack(depth + 1),
        _ => 0,
    };
    below + room.iter().sum::<u32>()
}
