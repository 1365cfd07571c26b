//! How deep the stack has been, by paint.
//!
//! # Limitations
//! It sees what has been written, so it is a high-water mark of what has run, not a proof for what could.

use core::ptr::{read_volatile, write_volatile};
use cortex_m::register::msp;

const PAINT: u32 = 0xC0DE_57AC;

/// Bytes below the stack pointer that painting itself may be using.
const OWN: usize = 64;

unsafe extern "C" {
    /// By `memory.x`: the stack may grow down to here.
    static mut _stack_end: u32;
}

/// The stack as it was when it was painted.
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
            // SAFETY: between the end of the stack and the stack pointer nothing lives, and
            // the words that this function itself uses are left out.
            unsafe { write_volatile(word as *mut u32, PAINT) };
            word += 4;
        }
        Self { top }
    }

    /// Bytes by which the stack has since grown beyond where it was painted; at least 64, which painting used itself.
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
