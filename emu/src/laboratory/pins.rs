//! The board's pins that the laboratory drives or reads.

use crate::nucleo::Nucleo;
use rigless::device::Level;
use rigless::session::Session;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::time::VirtualNanos;

// The wiring, see the firmware's board module.
pub(super) const PERMIT_PIN: u32 = 9;
const STOP_PIN: u8 = 11;
pub(super) const STEP_PIN: u32 = 13;
pub(super) const PULSE_PIN: u32 = 14;
const CHAIN_PIN: u8 = 15;
const PORT_E: usize = 4;
/// The blue button, by port and pin.
pub(super) const BUTTON: (usize, u8) = (2, 13);

/// The emergency stop's contact: closed to ground, or open, so that the pull-up decides.
pub(super) fn stop_contact(session: &mut Session<Nucleo>, at: VirtualNanos, closed: bool) {
    drive(
        session,
        at,
        (PORT_E, STOP_PIN),
        closed.then_some(Level::Low),
    );
}

/// The contact of the permission chain: closed to the supply, or open, so that the pull-down decides.
pub(super) fn chain_contact(session: &mut Session<Nucleo>, at: VirtualNanos, closed: bool) {
    drive(
        session,
        at,
        (PORT_E, CHAIN_PIN),
        closed.then_some(Level::High),
    );
}

/// Drives a pin from outside, or releases it.
pub(super) fn drive(
    session: &mut Session<Nucleo>,
    at: VirtualNanos,
    (port, pin): (usize, u8),
    level: Option<Level>,
) {
    if let Some(pin) = Pin::new(pin) {
        session
            .board_mut()
            .chip
            .drive_port(at, port, |port, registers, context| {
                port.drive(pin, level, registers, context);
            });
    }
}
