//! AD7606 and AD5761R on the board: where their pins go, and what the timers do with them.

use super::Shown;
use super::ad5761r::Ad5761r;
use super::ad7606::Ad7606;
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

/// SPI1 and SPI3, ports B and D, TIM2 in the chip's lists.
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

/// Acceleration at full scale of its input, m/s^2.
const FULL_SCALE_M_PER_S2: f64 = 50.0;

/// Hangs both chips on the board's serial interfaces.
pub fn attach(board: &mut Nucleo) {
    let on = |pin| Pin::new(pin).map(selected_by);
    if let (Some(cs), Some(sync)) = (on(CS_PIN), on(SYNC_PIN)) {
        board.chip.spi[SPI1].attach_selected(Ad7606::default(), cs);
        board.chip.spi[SPI3].attach_selected(Ad5761r::default(), sync);
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

/// What happens between the chips and the board's pins.
#[derive(Debug, Default)]
pub struct External {
    /// When BUSY falls.
    busy_until: Option<VirtualNanos>,
    /// Levels of CONVST, LDAC and RESET as pins of ports.
    convst: bool,
    ldac: bool,
    reset: bool,
}

impl External {
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

    /// BUSY falls then.
    pub fn next_turn(&self) -> Option<VirtualNanos> {
        self.busy_until
    }

    /// It falls.
    pub fn turn(&mut self, session: &mut Session<Nucleo>, registers: &Registers, at: VirtualNanos) {
        if self.busy_until.take_if(|until| *until <= at).is_some() {
            if let Some(adc) = chip::<Ad7606>(session, SPI1) {
                adc.settle(at.0);
            }
            busy(session, registers, at, Level::Low);
        }
    }

    /// CONVST, LDAC and RESET as the program itself moves them.
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

    /// The chip's pins float; outside they are pulled to where nothing happens.
    pub fn reset(&mut self) {
        (self.convst, self.ldac, self.reset) = (false, true, false);
    }
}

/// A pin after a write of its port's set and reset register; returns how it was.
fn moved(level: &mut bool, value: u64, pin: u32) -> bool {
    let was = *level;
    if value >> pin & 1 == 1 {
        *level = true;
    } else if value >> (pin + 16) & 1 == 1 {
        *level = false;
    }
    was
}

/// BUSY's level, to the pin and, where the pin is the timer's, to the timer.
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

/// What stands at the AD7606's inputs: the rig's sensors, and the AD5761R's output at V3.
pub fn show(session: &mut Session<Nucleo>, shown: Shown) {
    let read_back = chip::<Ad5761r>(session, SPI3).map_or(0.0, |dac| dac.volts());
    let acceleration = shown.acceleration_m_per_s2 / FULL_SCALE_M_PER_S2 * 10.0;
    let of_volts = |volts: f64| (volts * 3276.8).round().clamp(-32768.0, 32767.0) as i16;
    let of_code = |code: f64| (code.round() - 32768.0).clamp(-32768.0, 32767.0) as i16;
    if let Some(adc) = chip::<Ad7606>(session, SPI1) {
        adc.inputs = [
            of_code(shown.displacement),
            of_code(shown.force),
            of_volts(read_back),
            of_code(shown.displacement),
            of_volts(acceleration),
            0,
            0,
            0,
        ];
    }
}

/// Codes of the command since this was last asked.
pub fn commands(session: &mut Session<Nucleo>) -> Vec<(u64, u16)> {
    chip::<Ad5761r>(session, SPI3).map_or_else(Vec::new, Ad5761r::commands)
}

fn load(session: &mut Session<Nucleo>, at_ns: u64) {
    if let Some(dac) = chip::<Ad5761r>(session, SPI3) {
        dac.load(at_ns);
    }
}

/// A period is over: LDAC fell at TIM4's compare, or was low all the while.
pub fn end_of_period(
    session: &mut Session<Nucleo>,
    registers: &Registers,
    trigger_ns: u64,
    timer_hz: u64,
) {
    // A chain with another compare value works, at another instant; one with the other polarity, all the time.
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

/// The code that stands for the output's voltage.
pub fn pin(session: &mut Session<Nucleo>) -> Option<u16> {
    let volts = chip::<Ad5761r>(session, SPI3)?.volts();
    Some(((volts + 10.0) * 3276.8).round().clamp(0.0, 65535.0) as u16)
}

/// The output stays where it is from now on.
pub fn break_output(session: &mut Session<Nucleo>) {
    if let Some(dac) = chip::<Ad5761r>(session, SPI3) {
        dac.break_output();
    }
}
