//! The settings that a debugger has left on the chip.

use embassy_stm32::pac;

/// Keeps the watchdog running while a debugger halts the core. A debugger's settings survive every reset but power-on.
#[inline]
pub fn watchdog_goes_on() {
    pac::DBGMCU.apb1fzr().write(|w| w.set_iwdg(false));
}
