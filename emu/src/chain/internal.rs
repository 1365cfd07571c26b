//! The chip's own converters. The emulator's ADC has only a software trigger, and there is no DAC: here is channel 1 of the
//! chip's. A code waits in the holding register for its trigger, and the pin shows the output register, or floats.

use super::beside;
use super::shown::{Instant, Shown, TOP};
use crate::nucleo::Nucleo;
use crate::registers::internal::OUTPUT;
use crate::registers::{ADC1_CR2, DAC_CR, DAC_DHR12R1, GPIOA_MODER, Registers, TIM4_CCR1};
use rigless::emulator::Host;
use rigless::session::Session;
use rigless::soc::stm32f427::peripherals::adc::Channel;
use std::collections::VecDeque;

const DISPLACEMENT_CHANNEL: u8 = 3;
const FORCE_CHANNEL: u8 = 10;

// Channels of ADC2.
const COMMAND_CHANNEL: u8 = 4;
const SECOND_DISPLACEMENT_CHANNEL: u8 = 13;
const ACCELERATION_CHANNEL: u8 = 12;

/// Acceleration at either end of its input, m/s^2.
const FULL_SCALE_M_PER_S2: f64 = 50.0;

const ENABLED: u64 = 1;
const TRIGGERED: u64 = 1 << 2;
const PA4: u64 = 3 << 8;

/// The DAC and its pin.
#[derive(Clone, Debug, Default)]
pub struct Internal {
    output: u16,
    /// Codes written and not yet loaded, with their times, ns.
    held: VecDeque<(u64, u16)>,
    /// All codes written since the last call of `commands`.
    commands: Vec<(u64, u16)>,
    /// The pin stays where it is.
    broken: bool,
    /// The code of the voltage that the pin keeps while it floats, if nothing loads it.
    charged: Option<u16>,
}

impl Internal {
    /// A register is written.
    pub fn written(&mut self, registers: &Registers, at_ns: u64, (address, value): (u64, u64)) {
        if address == DAC_DHR12R1 {
            let code = value as u16 & 0xfff;
            self.commands.push((at_ns, code));
            self.hold(registers, at_ns, code);
        }
    }

    /// Codes written since the last call.
    pub fn commands(&mut self) -> Vec<(u64, u16)> {
        std::mem::take(&mut self.commands)
    }

    /// From now on the pin stays where it is.
    pub fn break_output(&mut self) {
        self.broken = true;
    }

    /// The pin floats from now on, and its follower hardly loads it: it keeps its voltage.
    pub fn keep_charge(&mut self) {
        self.charged = Some(self.output);
    }

    /// The holding register is written.
    pub fn hold(&mut self, registers: &Registers, at_ns: u64, code: u16) {
        if self.broken {
            return;
        }
        if registers.read(DAC_CR) & TRIGGERED == 0 {
            self.output = code;
            self.held.clear();
        } else {
            self.held.push_back((at_ns, code));
        }
    }

    /// A period that began at `trigger_ns` is over: the code in the holding register at TIM4's compare is now the output.
    pub fn end_of_period(&mut self, registers: &Registers, trigger_ns: u64, timer_hz: u64) {
        // With another compare value the output changes at another instant.
        let chain = OUTPUT.iter().filter(|d| d.address != TIM4_CCR1);
        if chain
            .clone()
            .any(|d| registers.read(d.address) & d.mask != d.value)
        {
            return;
        }
        let delay_ns = registers.read(TIM4_CCR1) * 1_000_000_000 / timer_hz;
        while let Some((_, code)) = self
            .held
            .pop_front_if(|(at, _)| *at <= trigger_ns + delay_ns)
        {
            self.output = code;
        }
    }

    /// What the pin shows; `None` while it floats.
    pub fn pin(&self, registers: &Registers) -> Option<u16> {
        let driven =
            registers.read(DAC_CR) & ENABLED != 0 && registers.read(GPIOA_MODER) & PA4 == PA4;
        driven.then_some(self.output).or(self.charged)
    }

    /// The chip is reset.
    pub fn reset(&mut self) {
        (self.output, self.held, self.charged) = (0, VecDeque::new(), None);
    }
}

/// Applies to each pin the voltage of one conversion: a sensor's code is the sum of two. `pin`: the output's code.
pub fn show(session: &mut Session<Nucleo>, shown: Shown, pin: Option<u16>) {
    let volts = |code: f64| code / f64::from(TOP) * 3.3;
    let acceleration = shown.acceleration_m_per_s2 / FULL_SCALE_M_PER_S2;
    beside::show(
        session,
        &[
            (COMMAND_CHANNEL, volts(f64::from(pin.unwrap_or(0)))),
            (
                SECOND_DISPLACEMENT_CHANNEL,
                volts(shown.second_displacement / 2.0),
            ),
            (ACCELERATION_CHANNEL, 1.65 * (1.0 + acceleration)),
        ],
    );
    let adc = &mut session.board_mut().chip.adc[0];
    let channels = [
        (DISPLACEMENT_CHANNEL, shown.displacement[0]),
        (FORCE_CHANNEL, shown.force[0]),
    ];
    for (channel, sum) in channels {
        if let Some(channel) = Channel::new(channel) {
            // The middle of the code, in tenths of one.
            let code = (sum / 2.0).round().clamp(0.0, f64::from(TOP)) as u32;
            adc.set_input(channel, code * 10 + 5);
        }
    }
}

/// Starts the conversions.
pub fn convert(session: &mut Session<Nucleo>, now: Instant, host: &mut dyn Host) {
    beside::start(session, ADC1_CR2, now, host);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registers::{RCC_AHB1ENR, RCC_APB1ENR};
    use crate::registers::{TIM4_CCMR1, TIM4_CR1, TIM4_CR2, TIM4_SMCR};

    fn registers(dac: u64) -> Registers {
        let mut r = Registers::default();
        for (address, value) in [
            (RCC_AHB1ENR, 1),
            (RCC_APB1ENR, 1 << 29 | 1 << 2),
            (TIM4_SMCR, 1 << 4 | 6),
            (TIM4_CR1, 1 << 3),
            (TIM4_CCMR1, 7 << 4),
            (TIM4_CCR1, 3360),
            (TIM4_CR2, 4 << 4),
            (GPIOA_MODER, PA4),
            (DAC_CR, dac),
        ] {
            r.write(address, value);
        }
        r
    }

    const WHOLE: u64 = 1 | 1 << 2 | 5 << 3;

    #[test]
    fn a_code_is_shown_from_the_compare_on_and_one_that_is_late_a_period_later() {
        let (mut dac, r) = (Internal::default(), registers(WHOLE));
        dac.hold(&r, 30_000, 100);
        dac.hold(&r, 41_000, 200);
        assert_eq!(dac.pin(&r), Some(0));
        dac.end_of_period(&r, 0, 84_000_000);
        assert_eq!(dac.pin(&r), Some(100));
        dac.end_of_period(&r, 500_000, 84_000_000);
        assert_eq!(dac.pin(&r), Some(200));
    }

    #[test]
    fn without_a_trigger_it_is_shown_at_once_and_with_a_wrong_one_never() {
        let (mut dac, r) = (Internal::default(), registers(1));
        dac.hold(&r, 0, 300);
        assert_eq!(dac.pin(&r), Some(300));
        let wrong = registers(1 | 1 << 2 | 4 << 3);
        dac.hold(&wrong, 0, 400);
        dac.end_of_period(&wrong, 0, 84_000_000);
        assert_eq!(dac.pin(&wrong), Some(300));
        assert_eq!(dac.pin(&registers(WHOLE & !1)), None);
    }
}
