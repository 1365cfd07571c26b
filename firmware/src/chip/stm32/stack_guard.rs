//! Forbids access below the stack, and code in the memory.
//!
//! The stack lies at the lower end of the memory (`memory.x`). The addresses below it are reserved, and RM0090 does not
//! say what an access there does. The memory protection unit makes it a fault, whatever the kind of access and wherever
//! a frame begins.

use core::ops::Range;
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::MPU;

unsafe extern "C" {
    /// From `memory.x`: the stack may grow down to here, the start of the memory.
    static _stack_end: u32;
}

/// Size of the forbidden range. A function that lowers the stack pointer by more than this at once could step over it:
/// a test keeps the largest frame below that.
const BYTES: u32 = 32 * 1024;

/// The forbidden range: it ends where the stack does.
pub fn range() -> Range<u32> {
    let end = (&raw const _stack_end).addr() as u32;
    end - BYTES..end
}

/// Its size as encoded for the unit: 2^(SIZE + 1) bytes.
const SIZE: u32 = BYTES.ilog2() - 1;

/// No read, write or execute (access permissions 000, XN).
const NO_ACCESS: u32 = 1 << 28;

/// The stack and the variables: 256 KiB from its end on.
const MEMORY_SIZE: u32 = 17;

/// Read and write for everyone, execute for nobody (access permissions 011, XN); write-back memory, as in the
/// processor's default map.
const DATA: u32 = 1 << 28 | 3 << 24 | 1 << 19 | 1 << 17 | 1 << 16;

const ENABLE: u32 = 1;

/// Elsewhere the processor's default map stays in force.
const DEFAULT_MAP: u32 = 1 << 2;

/// Closes it from now on.
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
