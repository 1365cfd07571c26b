//! Stack depth, measured by painting.
//!
//! # Limitations
//! It sees only what was written: a high-water mark of the code that has run, not a proof for all code.

use core::ptr::{read_volatile, write_volatile};
use cortex_m::register::msp;

const PAINT: u32 = 0xC0DE_57AC;

/// Bytes below the stack pointer that painting itself may use.
const OWN: usize = 64;

unsafe extern "C" {
    /// From `memory.x`: the stack may grow down to here.
    static mut _stack_end: u32;
}

/// The stack at the time it was painted.
pub struct HighWater {
    top: usize,
}

impl HighWater {
    /// Paints all of the free stack.
    #[inline(never)]
    pub fn paint() -> Self {
        let top = msp::read() as usize;
        let mut word = bottom();
        while word < top - OWN {
            // SAFETY: nothing lives between the end of the stack and the stack pointer, and the words used by this
            // function itself are left out.
            unsafe { write_volatile(word as *mut u32, PAINT) };
            word += 4;
        }
        Self { top }
    }

    /// Bytes by which the stack has since grown beyond the painted point; at least the 64 used by painting itself.
    #[inline(never)]
    pub fn bytes(&self) -> usize {
        let mut word = bottom();
        // SAFETY: as above; words in use are only read.
        while word < self.top - OWN && unsafe { read_volatile(word as *const u32) } == PAINT {
            word += 4;
        }
        self.top - word
    }
}

fn bottom() -> usize {
    (&raw mut _stack_end).addr()
}
