//! Critical sections that do not block the control interrupt: they mask by priority (BASEPRI), not all (PRIMASK).
//!
//! They mask every interrupt but those of priority 0, which only the control interrupt has. The price: it must touch
//! nothing that a critical section protects.

use core::sync::atomic::{Ordering::SeqCst, compiler_fence};
use cortex_m::register::basepri;
use critical_section::{Impl, RawRestoreState, set_impl};

/// Priority 1 and below; the chip has four bits of priority, the upper ones.
const MASK: u8 = 1 << 4;

struct ByPriority;
set_impl!(ByPriority);

// SAFETY: there is one core; thread mode and every interrupt that uses critical sections have priority 1 or less, and
// those do not interrupt each other while BASEPRI is at `MASK`.
unsafe impl Impl for ByPriority {
    unsafe fn acquire() -> RawRestoreState {
        let before = basepri::read();
        // SAFETY: masking more is always sound.
        unsafe { basepri::write(MASK) };
        compiler_fence(SeqCst);
        before
    }

    unsafe fn release(before: RawRestoreState) {
        compiler_fence(SeqCst);
        // SAFETY: restores what the matching `acquire` found.
        unsafe { basepri::write(before) };
    }
}
