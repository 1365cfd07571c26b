//! What the control interrupt owns.

use super::converters::Converters;
use super::kept;
use super::metal::Metal;
use crate::station::Station;
use core::cell::UnsafeCell;

/// What the control interrupt owns on a board with `A` actuators.
pub struct Control<C, const A: usize = 1> {
    /// The loop and what is around it.
    pub station: Station<A>,
    /// The board's inputs and outputs.
    pub metal: Metal<C>,
}

/// Its place, in an image of its own.
pub struct ControlCell<C, const A: usize = 1>(UnsafeCell<Option<Control<C, A>>>);

// SAFETY: written once before the interrupt is on, and reached only by the interrupt from then on.
unsafe impl<C, const A: usize> Sync for ControlCell<C, A> {}

impl<C: Converters<A>, const A: usize> ControlCell<C, A> {
    /// Empty.
    #[expect(clippy::new_without_default, reason = "only as a static")]
    pub const fn new() -> Self {
        Self(UnsafeCell::new(None))
    }

    /// Gives the control interrupt what it owns, and switches it on. To be called once.
    pub fn begin(&'static self, control: Control<C, A>) {
        // SAFETY: the interrupt is off, so nobody else is there.
        unsafe { *self.0.get() = Some(control) };
        // SAFETY: what it uses is in place. Its first run starts the period.
        unsafe { C::enable_interrupt() };
    }

    /// One control period.
    ///
    /// # Safety
    /// Called by the control interrupt and by nobody else.
    #[inline]
    pub unsafe fn period(&self) {
        // SAFETY: the interrupt does not interrupt itself, and nobody else reaches this.
        if let Some(control) = unsafe { &mut *self.0.get() } {
            control.station.period(&mut control.metal);
            kept::note_mode(control.station.mode());
        }
        // ARM erratum 838869: a store just before the return could make the processor take the wrong vector.
        cortex_m::asm::dsb();
    }
}
