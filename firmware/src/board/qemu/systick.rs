//! SysTick as a stopwatch.
//!
//! Under `-icount` the emulated clock advances by a fixed time per instruction, so this counts instructions;
//! [`SysTick::ticks_per_1024_instructions`] measures the ratio.

use core::arch::asm;
use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m::peripheral::{SYST, syst::SystClkSource};

/// The counter has 24 bits and counts down.
const TURN: u32 = 0x00FF_FFFF;

/// The running counter.
pub struct SysTick;

impl SysTick {
    /// Starts the counter at the processor's clock.
    pub fn start(mut counter: SYST) -> Self {
        counter.set_clock_source(SystClkSource::Core);
        counter.set_reload(TURN);
        counter.clear_current();
        counter.enable_counter();
        Self
    }

    /// Ticks of 1024 instructions, and those of an empty measurement.
    #[inline(never)]
    pub fn ticks_per_1024_instructions(&self) -> (u32, u32) {
        let begin = self.now();
        let nothing = self.now();
        // SAFETY: 1024 instructions without effect.
        unsafe { asm!(".rept 1024", "nop", ".endr", options(nomem, nostack)) };
        let end = self.now();
        let overhead = Self::between(begin, nothing);
        (Self::between(nothing, end) - overhead, overhead)
    }

    /// Ticks from `earlier` to `later`, less than a turn of the counter.
    #[inline]
    pub fn between(earlier: u32, later: u32) -> u32 {
        earlier.wrapping_sub(later) & TURN
    }

    /// The counter.
    #[inline]
    pub fn now(&self) -> u32 {
        // Earlier writes complete before the clock is read, and vice versa.
        compiler_fence(Ordering::SeqCst);
        let ticks = SYST::get_current();
        compiler_fence(Ordering::SeqCst);
        ticks
    }
}
