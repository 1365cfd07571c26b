//! No access below the stack, and no code in the memory.
//!
//! The stack lies at the lower end of the memory (`memory.x`). What is below it is reserved, and RM0090 does not say what
//! an access there does. The memory protection unit says it: a fault, whatever kind of access it is and wherever a frame
//! begins.

use core::ops::Range;
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::MPU;

/// What nobody may touch: it ends where the stack does (`memory.x`). A function that takes more than these 32 KiB off the
/// stack pointer at once could step over it: a test holds the largest frame below that.
pub const RANGE: Range<u32> = 0x1fff_8000..0x2000_0000;

/// Its size as the unit takes it: 2^(SIZE + 1) bytes.
const SIZE: u32 = RANGE.end.wrapping_sub(RANGE.start).ilog2() - 1;

/// Nobody may read, write or execute (access permissions 000, XN).
const NO_ACCESS: u32 = 1 << 28;

/// The variables and the stack: 256 KiB from here.
const MEMORY: u32 = 0x2000_0000;
const MEMORY_SIZE: u32 = 17;

/// Everybody may read and write, nobody execute (access permissions 011, XN); write-back memory, as the processor's own map
/// has it there.
const DATA: u32 = 1 << 28 | 3 << 24 | 1 << 19 | 1 << 17 | 1 << 16;

const ENABLE: u32 = 1;

/// Everywhere else the processor's own map stays in force.
const DEFAULT_MAP: u32 = 1 << 2;

/// From now on.
pub fn close(mpu: &mut MPU) {
    let regions = [
        (RANGE.start, NO_ACCESS | SIZE << 1),
        (MEMORY, DATA | MEMORY_SIZE << 1),
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
