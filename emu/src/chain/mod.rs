//! The converters between the rig and the chip: the chip's own, or external ones on its serial interfaces.

pub mod ad5754r;
pub mod ad5761r;
pub mod ad7606;
pub mod beside;
pub mod external;
pub mod internal;
mod output;
mod shift;
mod shown;

pub use shown::{Instant, Shown};

use crate::log::InjectedFault;
use crate::nucleo::Nucleo;
use crate::registers::{Demand, Registers};
use external::External;
use internal::Internal;
use link::CodeRange;
use link::channel::{Calibration, ChannelCalibration};
use rigless::emulator::Host;
use rigless::session::Session;
use rigless::time::VirtualNanos;
use serde::Deserialize;
use shown::TOP;

/// Which converters an image is for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Converters {
    /// Two conversions of 12 bits an input, and the chip's DAC.
    #[default]
    Internal,
    /// AD7606 and AD5761R.
    External,
    /// AD7606 and AD5754R, for three actuators.
    Three,
}

impl Converters {
    /// Number of actuators.
    pub fn actuators(self) -> usize {
        match self {
            Self::Internal | Self::External => 1,
            Self::Three => 3,
        }
    }

    /// Highest codes of sensors and command.
    pub fn widths(self) -> CodeRange {
        let (sensor_top, command_top) = match self {
            Self::Internal => (2 * TOP, TOP),
            Self::External | Self::Three => (u16::MAX, u16::MAX),
        };
        CodeRange {
            sensor_top,
            sensor_rail: 0,
            sensor_spare: 0,
            command_top,
            command_spare: 0,
        }
    }
}

impl Nucleo {
    /// With what is outside the chip: the chip's own converters need nothing.
    #[must_use]
    pub fn with_converters(mut self, converters: Converters) -> Self {
        if converters != Converters::Internal {
            external::attach(&mut self, converters.actuators());
        }
        self
    }
}

/// The converters and what they show.
#[derive(Debug)]
pub enum Chain {
    /// The chip's own.
    Internal(Internal),
    /// External ones.
    External(External),
}

impl Chain {
    /// Of a kind.
    pub fn new(converters: Converters) -> Self {
        match converters {
            Converters::Internal => Self::Internal(Internal::default()),
            Converters::External | Converters::Three => {
                Self::External(External::new(converters.actuators()))
            }
        }
    }

    /// Which they are.
    pub fn converters(&self) -> Converters {
        match self {
            Self::Internal(_) => Converters::Internal,
            Self::External(external) if external.actuators == 1 => Converters::External,
            Self::External(_) => Converters::Three,
        }
    }

    /// What must stand in the registers, beside the guards.
    pub fn demands(&self) -> [&'static [Demand]; 3] {
        use crate::registers::{external, internal};
        match self {
            Self::Internal(_) => [&internal::SAMPLING, &internal::PINS, &internal::OUTPUT],
            Self::External(chips) => {
                let output = match chips.actuators {
                    1 => &external::OUTPUT,
                    _ => &external::OUTPUT_OF_THREE,
                };
                [&external::SAMPLING, &external::READING, output]
            }
        }
    }

    /// What must stand in the registers for what is recorded beside; nothing where external converters record it.
    pub fn demands_beside(&self) -> [&'static [Demand]; 2] {
        use crate::registers::beside;
        match self.converters() {
            Converters::Internal => [&beside::CONVERTING, &beside::OF_ONE],
            Converters::External => [&[], &[]],
            Converters::Three => [&beside::CONVERTING, &beside::OF_THREE],
        }
    }

    /// Puts what the rig shows onto the inputs.
    pub fn show(&mut self, session: &mut Session<Nucleo>, registers: &Registers, shown: Shown) {
        match self {
            Self::Internal(internal) => internal::show(session, shown, internal.pin(registers)),
            Self::External(chips) => external::show(session, shown, chips.actuators),
        }
    }

    /// The sampling timer's update: starts the conversions if the registers are such that it does.
    pub fn update(
        &mut self,
        session: &mut Session<Nucleo>,
        registers: &Registers,
        now: Instant,
        host: &mut dyn Host,
    ) -> bool {
        let starts = registers.meet(self.demands()[0]);
        if starts {
            match self {
                Self::Internal(_) => internal::convert(session, now, host),
                Self::External(external) => external.convert(session, registers, now.at),
            }
        }
        let [converting, _] = self.demands_beside();
        if !converting.is_empty() && registers.meet(converting) {
            beside::convert(session, now, host);
        }
        starts
    }

    /// The next instant at which a converter has something to do by itself.
    pub fn next_turn(&self) -> Option<VirtualNanos> {
        match self {
            Self::Internal(_) => None,
            Self::External(external) => external.next_turn(),
        }
    }

    /// That instant has come.
    pub fn turn(&mut self, session: &mut Session<Nucleo>, registers: &Registers, at: VirtualNanos) {
        if let Self::External(external) = self {
            external.turn(session, registers, at);
        }
    }

    /// A register was written.
    pub fn written(
        &mut self,
        session: &mut Session<Nucleo>,
        registers: &Registers,
        at: VirtualNanos,
        (address, value): (u64, u64),
    ) {
        match self {
            Self::Internal(internal) => internal.written(registers, at.0, (address, value)),
            Self::External(external) => external.written(session, registers, at, (address, value)),
        }
    }

    /// Codes of the command since this was last asked, with their times, ns.
    pub fn commands(&mut self, session: &mut Session<Nucleo>) -> Vec<(u64, u16)> {
        match self {
            Self::Internal(internal) => internal.commands(),
            Self::External(_) => external::commands(session),
        }
    }

    /// A period that began at `trigger_ns` is over: what stood at TIM4's compare is shown since.
    pub fn end_of_period(
        &mut self,
        session: &mut Session<Nucleo>,
        registers: &Registers,
        trigger_ns: u64,
        timer_hz: u64,
    ) {
        match self {
            Self::Internal(internal) => internal.end_of_period(registers, trigger_ns, timer_hz),
            Self::External(_) => external::end_of_period(session, registers, trigger_ns, timer_hz),
        }
    }

    /// What an actuator's output shows; `None` while it floats.
    pub fn pin(
        &self,
        session: &mut Session<Nucleo>,
        registers: &Registers,
        actuator: usize,
    ) -> Option<u16> {
        match self {
            Self::Internal(internal) => internal.pin(registers),
            Self::External(_) => external::pin(session, actuator),
        }
    }

    /// The chip is reset; converters outside it are not.
    pub fn reset(&mut self) {
        match self {
            Self::Internal(internal) => internal.reset(),
            Self::External(external) => external.reset(),
        }
    }

    /// The supply of a converter outside the chip goes and comes back, or its data line is stuck; of the chip's own nothing.
    pub fn disturb(&mut self, session: &mut Session<Nucleo>, fault: InjectedFault) {
        if let Self::External(_) = self {
            match fault {
                InjectedFault::OutputDips => external::dip_output(session),
                InjectedFault::InputDips => external::dip_input(session),
                InjectedFault::InputScale { percent } => external::scale_input(session, percent),
                InjectedFault::InputStands => external::stand_input(session),
                InjectedFault::SlowInput => external::slow_input(session),
                InjectedFault::StuckData { high } => external::stick_data(session, high),
                _ => {}
            }
        }
    }

    /// A bit of the next frame from the input converter outside the chip turns over.
    pub fn turn_over_input(&mut self, session: &mut Session<Nucleo>, bit: u32) {
        if let Self::External(_) = self {
            external::turn_over_input(session, bit);
        }
    }

    /// A bit of the next command to the output converter outside the chip turns over.
    pub fn turn_over_output(&mut self, session: &mut Session<Nucleo>, bit: u32) {
        if let Self::External(_) = self {
            external::turn_over_output(session, bit);
        }
    }

    /// An actuator's output no longer follows its command.
    pub fn break_output(&mut self, session: &mut Session<Nucleo>, actuator: usize) {
        match self {
            Self::Internal(internal) => internal.break_output(),
            Self::External(_) => external::break_output(session, actuator),
        }
    }
}

/// The displacement that a code commands, m.
pub fn command_m(wired: &Calibration, code: u16) -> f64 {
    let line = wired.command;
    (f64::from(code) - f64::from(line.zero_code)) * f64::from(line.per_code)
}

/// The code of a sensor, with its fraction, that stands for a quantity, m or N.
pub fn sensor_code(line: ChannelCalibration, quantity: f64) -> f64 {
    quantity / f64::from(line.per_code) + f64::from(line.zero_code)
}
