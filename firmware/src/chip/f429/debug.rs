//! What a debugger has set on the chip.

use embassy_stm32::pac;

/// The watchdog counts on while a debugger halts the core. A debugger's settings outlast every reset but that of power-on.
#[inline]
pub fn watchdog_goes_on() {
    pac::DBGMCU.apb1fzr().write(|w| w.set_iwdg(false));
}
