//! The cause of the chip's start.

use embassy_stm32::pac;
use link::status::StartCause;

/// Why the chip started; clears the flags for the next time.
pub fn cause() -> StartCause {
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    if flags.wdgrstf() || flags.wwdgrstf() {
        StartCause::Watchdog
    } else if flags.sftrstf() {
        StartCause::Software
    } else if flags.porrstf() {
        StartCause::Power
    } else if flags.borrstf() {
        StartCause::BrownOut
    } else {
        StartCause::Pin
    }
}
