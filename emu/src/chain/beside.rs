//! The chip's second converter, which samples what is recorded outside the control path. The emulator's converters have only a
//! software trigger: it is given where the registers say that the timer's update starts them.

use super::shown::{Instant, TOP};
use crate::nucleo::Nucleo;
use crate::registers::ADC2_CR2;
use rigless::emulator::{Access, AccessKind, Host};
use rigless::session::Session;
use rigless::soc::Width;
use rigless::soc::stm32f427::peripherals::adc::Channel;

const JSWSTART: u64 = 1 << 22;

/// Its supply and full scale, V.
const SUPPLY_V: f64 = 3.3;

/// Amplifier in front of an input of -10 to +10 V: gain, and the middle of its output, V.
const GAIN: f64 = 0.15;
const MIDDLE_V: f64 = 1.65;

/// The amplifier's output for an input voltage.
pub fn amplified_v(volts: f64) -> f64 {
    MIDDLE_V + GAIN * volts
}

/// Applies voltages to channels.
pub fn show(session: &mut Session<Nucleo>, shown: &[(u8, f64)]) {
    let adc = &mut session.board_mut().chip.adc[1];
    for (channel, volts) in shown {
        if let Some(channel) = Channel::new(*channel) {
            let code = (volts / SUPPLY_V * f64::from(TOP)).round();
            // The middle of the code, in tenths of one.
            let code = code.clamp(0.0, f64::from(TOP)) as u32;
            adc.set_input(channel, code * 10 + 5);
        }
    }
}

/// Starts the conversions.
pub fn convert(session: &mut Session<Nucleo>, now: Instant, host: &mut dyn Host) {
    start(session, ADC2_CR2, now, host);
}

/// Starts the injected conversions of the converter with this control register.
pub(super) fn start(session: &mut Session<Nucleo>, cr2: u64, now: Instant, host: &mut dyn Host) {
    let Instant { at, instructions } = now;
    let read = Access::new(AccessKind::Read, cr2, Width::W32, 0);
    let (value, _) = session.access(read.at(instructions, at), host);
    let write = Access::new(AccessKind::Write, cr2, Width::W32, value | JSWSTART);
    session.access(write.at(instructions, at), host);
}
