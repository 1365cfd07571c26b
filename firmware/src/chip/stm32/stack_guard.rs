//! No access below the stack, and no code in the memory.
//!
//! The stack lies at the lower end of the memory (`memory.x`). What is below it is reserved, and RM0090 does not say what
//! an access there does. The memory protection unit says it: a fault, whatever kind of access it is and wherever a frame
//! begins.

use core::ops::Range;
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::MPU;

unsafe extern "C" {
    /// By `memory.x`: the stack may grow down to here, where the memory begins.
    static _stack_end: u32;
}

/// Bytes that nobody may touch. A function that takes more than these off the stack pointer at once could step over them: a
/// test holds the largest frame below that.
const BYTES: u32 = 32 * 1024;

/// Where they are: they end where the stack does.
pub fn range() -> Range<u32> {
    let end = (&raw const _stack_end).addr() as u32;
    end - BYTES..end
}

/// Their size as the unit takes it: 2^(SIZE + 1) bytes.
const SIZE: u32 = BYTES.ilog2() - 1;

/// Nobody may read, write or execute (access permissions 000, XN).
const NO_ACCESS: u32 = 1 << 28;

/// The stack and the variables: 256 KiB from its end on.
const MEMORY_SIZE: u32 = 17;

/// Everybody may read and write, nobody execute (access permissions 011, XN); write-back memory, as the processor's own map
/// has it there.
const DATA: u32 = 1 << 28 | 3 << 24 | 1 << 19 | 1 << 17 | 1 << 16;

const ENABLE: u32 = 1;

/// Everywhere else the processor's own map stays in force.
const DEFAULT_MAP: u32 = 1 << 2;

/// From now on.
pub fn close(mpu: &mut MPU) {
    let range = range();
    let regions = [
        (range.start, NO_ACCESS | SIZE << 1),
        (range.end, DATA | MEMORY_SIZE << 1),
    ];
    // SAFETY: nothing of the program lies below the stack, and none of its code in the memory.
    unsafe {
        for (number, (begin, attributes)) in (0..).zip(regions) {
            mpu.rnr.write(number);
            mpu.rbar.write(begin);
            mpu.rasr.write(attributes | ENABLE);
        }
        mpu.ctrl.write(DEFAULT_MAP | ENABLE);
    }
    dsb();
    isb();
}
