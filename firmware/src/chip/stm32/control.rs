//! The state of the control interrupt.

use super::converters::Converters;
use super::kept;
use super::metal::Metal;
use crate::station::Station;
use core::cell::UnsafeCell;

/// The state of the control interrupt on a board with `A` actuators.
pub struct Control<C, const A: usize = 1> {
    /// The loop and its surroundings.
    pub station: Station<A>,
    /// The board's inputs and outputs.
    pub metal: Metal<C>,
}

/// Its place in an image.
pub struct ControlCell<C, const A: usize = 1>(UnsafeCell<Option<Control<C, A>>>);

// SAFETY: written once before the interrupt is on, and accessed only by the interrupt from then on.
unsafe impl<C, const A: usize> Sync for ControlCell<C, A> {}

impl<C: Converters<A>, const A: usize> ControlCell<C, A> {
    /// Empty.
    #[expect(clippy::new_without_default, reason = "only as a static")]
    pub const fn new() -> Self {
        Self(UnsafeCell::new(None))
    }

    /// Hands the control interrupt its state, and enables it. Must be called only once.
    pub fn begin(&'static self, control: Control<C, A>) {
        // SAFETY: the interrupt is off, so nothing else accesses it.
        unsafe { *self.0.get() = Some(control) };
        // SAFETY: everything it uses is in place. Its first run starts the period.
        unsafe { C::enable_interrupt() };
    }

    /// One control period.
    ///
    /// # Safety
    /// Only the control interrupt may call this.
    #[inline]
    pub unsafe fn period(&self) {
        // SAFETY: the interrupt does not interrupt itself, and nothing else accesses this.
        if let Some(control) = unsafe { &mut *self.0.get() } {
            control.station.period(&mut control.metal);
            kept::note_mode(control.station.mode());
        }
        // ARM erratum 838869: a store just before the return could make the processor take the wrong vector.
        cortex_m::asm::dsb();
    }
}
