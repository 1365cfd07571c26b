//! The guard of the chip's supply.

use crate::chip::stm32::fatal;
use embassy_stm32::interrupt::{InterruptExt, Priority};
use embassy_stm32::{interrupt, pac};

/// The threshold of 2.9 V, PLS = 111.
const SUPPLY_2_9_V: u8 = 7;

/// The supply monitor's line among the external interrupts.
const SUPPLY_LINE: usize = 16;

/// Monitors the supply: below 2.9 V the program ends while it still can. It needs 2.7 V at 168 MHz, and the chip's own
/// reset acts only at 1.8 V.
pub fn guard() {
    pac::RCC.apb1enr().modify(|w| w.set_pwren(true));
    pac::PWR.cr1().modify(|w| {
        w.set_pls(SUPPLY_2_9_V);
        w.set_pvde(true);
    });
    // A supply that is low from the start produces no edge: nothing begins until it is sufficient.
    while pac::PWR.csr1().read().pvdo() {}
    pac::EXTI.rtsr(0).modify(|w| w.set_line(SUPPLY_LINE, true));
    pac::EXTI.pr(0).write(|w| w.set_line(SUPPLY_LINE, true));
    pac::EXTI.imr(0).modify(|w| w.set_line(SUPPLY_LINE, true));
    interrupt::PVD.set_priority(Priority::P0);
    // SAFETY: its handler uses nothing that needs to be put in place.
    unsafe { interrupt::PVD.enable() };
}

/// Acts as the guard would, for a drill.
pub fn pend() {
    interrupt::PVD.pend();
}

/// The supply is below 2.9 V.
#[interrupt]
fn PVD() {
    fatal::supply_is_low()
}
