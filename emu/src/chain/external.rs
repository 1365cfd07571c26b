//! An AD7606 and an AD5761R (for three actuators an AD5754R) on the board: where their pins go, and how the timers drive
//! them.

use super::ad5754r::Ad5754r;
use super::ad5761r::Ad5761r;
use super::ad7606::Ad7606;
use super::beside;
use super::output::{OnBus, Output};
use super::shown::Shown;
use crate::nucleo::Nucleo;
use crate::registers::external::OUTPUT;
use crate::registers::{
    GPIOB_AFRH, GPIOB_BSRR, GPIOB_MODER, GPIOD_BSRR, GPIOD_MODER, GPIOF_BSRR, GPIOF_MODER,
    Registers, TIM4_CCER, TIM4_CCR1,
};
use rigless::chip::spi::Peer;
use rigless::device::Level;
use rigless::session::Session;
use rigless::soc::stm32f427::peripherals::gpio::Pin;
use rigless::soc::stm32f427::peripherals::spi::Select;
use rigless::soc::stm32f427::peripherals::tim::Channel;
use rigless::time::VirtualNanos;

/// Indices of SPI1, SPI3, port B and TIM2 in the chip's lists.
const SPI1: usize = 0;
const SPI3: usize = 2;
const PORT_B: usize = 1;
const TIM2: usize = 0;

// The wiring, see the firmware's board module.
const CONVST_PIN: u32 = 10;
const BUSY_PIN: u32 = 11;
const LDAC_PIN: u32 = 12;
const RESET_PIN: u32 = 12;
const CS_PIN: u8 = 14;
const SYNC_PIN: u8 = 2;
const BUSY_CHANNEL: u8 = 4;

/// Half of the board's 3.3 V: a divider of two 10 kOhm resistors, loaded by 1 MOhm.
const KNOWN_V: f64 = 1.65 * 0.995;

/// Codes of 16 bits over +-10 V.
const CODES_PER_V: f64 = 3276.8;

/// Acceleration at full scale of its input, m/s^2.
const FULL_SCALE_M_PER_S2: f64 = 50.0;

/// Attaches both chips for this number of actuators to the board's serial interfaces.
pub fn attach(board: &mut Nucleo, actuators: usize) {
    let on = |pin| Pin::new(pin).map(selected_by);
    if let (Some(cs), Some(sync)) = (on(CS_PIN), on(SYNC_PIN)) {
        board.chip.spi[SPI1].attach_selected(Ad7606::default(), cs);
        let bus = &mut board.chip.spi[SPI3];
        let output = match actuators {
            1 => OnBus::new(Ad5761r::default()),
            _ => OnBus::new(Ad5754r::default()),
        };
        bus.attach_selected(output, sync);
    }
}

fn selected_by(pin: Pin) -> Select {
    Select {
        port: "GPIOD",
        pin,
        active: Level::Low,
    }
}

fn chip<P: Peer>(session: &mut Session<Nucleo>, spi: usize) -> Option<&mut P> {
    session.board_mut().chip.spi[spi].chip_mut(0)
}

/// The output converter.
fn output(session: &mut Session<Nucleo>) -> Option<&mut dyn Output> {
    chip::<OnBus>(session, SPI3).map(|bus| bus.chip.as_mut() as &mut dyn Output)
}

/// Signals between the chips and the board's pins.
#[derive(Debug)]
pub struct External {
    /// Number of actuators.
    pub actuators: usize,
    /// When BUSY falls.
    busy_until: Option<VirtualNanos>,
    /// Levels of CONVST, LDAC and RESET as pins of ports.
    convst: bool,
    ldac: bool,
    reset: bool,
}

impl External {
    /// For this number of actuators.
    pub fn new(actuators: usize) -> Self {
        Self {
            actuators,
            busy_until: None,
            convst: false,
            ldac: false,
            reset: false,
        }
    }

    /// CONVST rises.
    pub fn convert(
        &mut self,
        session: &mut Session<Nucleo>,
        registers: &Registers,
        at: VirtualNanos,
    ) {
        let ends = chip::<Ad7606>(session, SPI1).and_then(|adc| adc.convert(at.0));
        if let Some(ends) = ends {
            self.busy_until = Some(VirtualNanos(ends));
            busy(session, registers, at, Level::High);
        }
    }

    /// When BUSY falls next.
    pub fn next_turn(&self) -> Option<VirtualNanos> {
        self.busy_until
    }

    /// Lets BUSY fall if that is due.
    pub fn turn(&mut self, session: &mut Session<Nucleo>, registers: &Registers, at: VirtualNanos) {
        if self.busy_until.take_if(|until| *until <= at).is_some() {
            if let Some(adc) = chip::<Ad7606>(session, SPI1) {
                adc.settle(at.0);
            }
            busy(session, registers, at, Level::Low);
        }
    }

    /// CONVST, LDAC and RESET as the program itself sets them.
    pub fn written(
        &mut self,
        session: &mut Session<Nucleo>,
        registers: &Registers,
        at: VirtualNanos,
        (address, value): (u64, u64),
    ) {
        let is_output = |moder, pin: u32| registers.read(moder) >> (2 * pin) & 3 == 1;
        match address {
            GPIOB_BSRR => {
                let was = moved(&mut self.convst, value, CONVST_PIN);
                if self.convst && !was && is_output(GPIOB_MODER, CONVST_PIN) {
                    self.convert(session, registers, at);
                }
            }
            GPIOD_BSRR => {
                let was = moved(&mut self.ldac, value, LDAC_PIN);
                if !self.ldac && was && is_output(GPIOD_MODER, LDAC_PIN) {
                    load(session, at.0);
                }
            }
            GPIOF_BSRR => {
                let was = moved(&mut self.reset, value, RESET_PIN);
                if !self.reset
                    && was
                    && is_output(GPIOF_MODER, RESET_PIN)
                    && let Some(adc) = chip::<Ad7606>(session, SPI1)
                {
                    adc.reset();
                }
            }
            _ => {}
        }
    }

    /// The chip's pins float; external resistors pull them to their inactive levels.
    pub fn reset(&mut self) {
        (self.convst, self.ldac, self.reset) = (false, true, false);
    }
}

/// Updates a pin by a write to its port's set and reset register; returns the level before.
fn moved(level: &mut bool, value: u64, pin: u32) -> bool {
    let was = *level;
    if value >> pin & 1 == 1 {
        *level = true;
    } else if value >> (pin + 16) & 1 == 1 {
        *level = false;
    }
    was
}

/// Drives BUSY's pin and, if the pin is assigned to the timer, the timer's input.
fn busy(session: &mut Session<Nucleo>, registers: &Registers, at: VirtualNanos, level: Level) {
    let board = &mut session.board_mut().chip;
    if let Some(pin) = Pin::new(BUSY_PIN as u8) {
        board.drive_port(at, PORT_B, |port, registers, context| {
            port.drive(pin, Some(level), registers, context);
        });
    }
    let mode = registers.read(GPIOB_MODER) >> (2 * BUSY_PIN) & 3;
    let function = registers.read(GPIOB_AFRH) >> (4 * (BUSY_PIN - 8)) & 15;
    if (mode, function) == (2, 1) {
        let Some(channel) = Channel::new(BUSY_CHANNEL) else {
            return;
        };
        board.drive_timer(at, TIM2, |timer, registers, context| {
            timer.drive_input(channel, level, registers, context);
        });
    }
}

/// Channels of the chip's own ADC2 that see the outputs of three actuators.
const OUTPUT_CHANNELS: [u8; 3] = [3, 10, 13];

/// Sets the AD7606's inputs: the rig's sensors, and the output at V3. With three actuators the outputs go to the chip's own
/// converter.
pub fn show(session: &mut Session<Nucleo>, shown: Shown, actuators: usize) {
    let output = output(session).map(|dac| [0, 1, 2].map(|place| dac.volts(place)));
    let read_back = output.map_or(0.0, |volts| volts[0]);
    let read_back = if shown.read_back_open { 0.0 } else { read_back };
    let acceleration = shown.acceleration_m_per_s2 / FULL_SCALE_M_PER_S2 * 10.0;
    let of_volts = |volts: f64| (volts * CODES_PER_V).round().clamp(-32768.0, 32767.0) as i16;
    let of_code = |code: f64| (code.round() - 32768.0).clamp(-32768.0, 32767.0) as i16;
    let (read_back, acceleration) = (of_volts(read_back), of_volts(acceleration));
    let known_v = if shown.known_gone { 0.0 } else { KNOWN_V };
    let known = of_volts(known_v + shown.known_noise / CODES_PER_V);
    let second = of_code(shown.second_displacement);
    let [d1, d2, d3] = shown.displacement.map(of_code);
    let [f1, f2, f3] = shown.force.map(of_code);
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        adc.inputs = match actuators {
            1 => [d1, f1, read_back, second, acceleration, known, 0, 0],
            _ => [d1, d2, d3, f1, f2, f3, second, known],
        };
    }
    if actuators > 1 {
        let volts = |place: usize| beside::amplified_v(output.map_or(0.0, |o| o[place]));
        let at = |place: usize| (OUTPUT_CHANNELS[place], volts(place));
        beside::show(session, &[at(0), at(1), at(2)]);
    }
}

/// Codes of the command since the last call.
pub fn commands(session: &mut Session<Nucleo>) -> Vec<(u64, u16)> {
    output(session).map_or_else(Vec::new, |dac| dac.commands())
}

fn load(session: &mut Session<Nucleo>, at_ns: u64) {
    if let Some(dac) = output(session) {
        dac.take_over(at_ns);
    }
}

/// A period is over: LDAC fell at TIM4's compare, or was low throughout.
pub fn end_of_period(
    session: &mut Session<Nucleo>,
    registers: &Registers,
    trigger_ns: u64,
    timer_hz: u64,
) {
    // With another compare value LDAC falls at another instant; with the other polarity it is always low.
    let chain = OUTPUT
        .iter()
        .filter(|d| !matches!(d.name, "TIM4_CCR1" | "TIM4_CCER.CC1P"));
    let mut missed = chain.filter(|d| registers.read(d.address) & d.mask != d.value);
    if missed.next().is_some() {
        return;
    }
    let inverted = registers.read(TIM4_CCER) & 2 == 2;
    let delay_ns = registers.read(TIM4_CCR1) * 1_000_000_000 / timer_hz;
    load(
        session,
        if inverted {
            trigger_ns + delay_ns
        } else {
            u64::MAX
        },
    );
}

/// The code for the voltage of an actuator's output.
pub fn pin(session: &mut Session<Nucleo>, actuator: usize) -> Option<u16> {
    let volts = output(session)?.volts(actuator);
    Some(((volts + 10.0) * CODES_PER_V).round().clamp(0.0, 65535.0) as u16)
}

/// The output converter's supply fails and returns: it is as after power-up.
pub fn dip_output(session: &mut Session<Nucleo>) {
    if let Some(dac) = output(session) {
        dac.lose_power();
    }
}

/// The AD7606's data line is stuck from now on.
pub fn stick_data(session: &mut Session<Nucleo>, high: bool) {
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        adc.stuck = Some(if high { Level::High } else { Level::Low });
    }
}

/// The AD7606's data line is open from now on.
pub fn open_data(session: &mut Session<Nucleo>) {
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        (adc.stuck, adc.coupled) = (Some(Level::Low), true);
    }
}

/// The AD7606's reference is wrong: it reads this percentage of its inputs.
pub fn scale_input(session: &mut Session<Nucleo>, percent: u32) {
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        adc.percent = Some(percent);
    }
}

/// The AD7606's results no longer change from now on, although BUSY falls.
pub fn stand_input(session: &mut Session<Nucleo>) {
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        adc.stands = true;
    }
}

/// From now on the AD7606 takes longer than the step waits.
pub fn slow_input(session: &mut Session<Nucleo>) {
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        adc.slow = true;
    }
}

/// The AD7606's supply fails and returns, without a reset.
pub fn dip_input(session: &mut Session<Nucleo>) {
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        adc.lose_power();
    }
}

/// A bit of the AD7606's next frame flips in transfer.
pub fn turn_over_input(session: &mut Session<Nucleo>, bit: u32) {
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        adc.turned = Some(bit);
    }
}

/// A bit of the next command flips in transfer.
pub fn turn_over_output(session: &mut Session<Nucleo>, bit: u32) {
    if let Some(bus) = chip::<OnBus>(session, SPI3) {
        bus.turned = Some(bit);
    }
}

/// An actuator's output stays where it is from now on.
pub fn break_output(session: &mut Session<Nucleo>, actuator: usize) {
    if let Some(dac) = output(session) {
        dac.break_output(actuator);
    }
}
