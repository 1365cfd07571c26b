//! The control interrupt.

use core::cell::UnsafeCell;
use embassy_stm32::interrupt;
use firmware::board::nucleo_f429zi::metal::Metal;
use firmware::board::nucleo_f429zi::{kept, start_control_interrupt};
use firmware::station::Station;

/// What the control interrupt owns.
pub struct Control {
    /// The loop and what is around it.
    pub station: Station,
    /// The board's hands.
    pub metal: Metal,
}

struct Owned(UnsafeCell<Option<Control>>);

// SAFETY: written once before the interrupt is on, and reached only by the interrupt from then on.
unsafe impl Sync for Owned {}

static CONTROL: Owned = Owned(UnsafeCell::new(None));

/// Gives the control interrupt what it owns, and switches it on. To be called once.
pub fn begin(control: Control) {
    // SAFETY: the interrupt is off, so nobody else is there.
    unsafe { *CONTROL.0.get() = Some(control) };
    // SAFETY: what it uses is in place. Its first run starts the period.
    unsafe { start_control_interrupt() };
}

/// End of the four conversions.
#[interrupt]
fn ADC() {
    // SAFETY: this interrupt does not interrupt itself, and nobody else reaches it.
    if let Some(control) = unsafe { &mut *CONTROL.0.get() } {
        control.station.period(&mut control.metal);
        kept::note_state(control.station.state());
    }
    // ARM erratum 838869: a store just before the return could make the processor take the wrong vector.
    cortex_m::asm::dsb();
}
