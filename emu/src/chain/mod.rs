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
    /// The chip's ADC, two conversions of 12 bits an input, and its DAC.
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
    /// Adds the external converters; the chip's own need nothing.
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
    /// For these converters.
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

    /// What the registers must hold, apart from [`crate::registers::GUARDS`].
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

    /// What the registers must hold for the inputs outside the control path; nothing where external converters sample them.
    pub fn demands_beside(&self) -> [&'static [Demand]; 2] {
        use crate::registers::beside;
        match self.converters() {
            Converters::Internal => [&beside::CONVERTING, &beside::OF_ONE],
            Converters::External => [&[], &[]],
            Converters::Three => [&beside::CONVERTING, &beside::OF_THREE],
        }
    }

    /// Applies the rig's readings to the inputs.
    pub fn show(&mut self, session: &mut Session<Nucleo>, registers: &Registers, shown: Shown) {
        match self {
            Self::Internal(internal) => internal::show(session, shown, internal.pin(registers)),
            Self::External(chips) => external::show(session, shown, chips.actuators),
        }
    }

    /// The sampling timer's update: starts the conversions if the registers allow it; returns whether it did.
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

    /// The next instant at which a converter acts by itself.
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

    /// Codes of the command since the last call, with their times, ns.
    pub fn commands(&mut self, session: &mut Session<Nucleo>) -> Vec<(u64, u16)> {
        match self {
            Self::Internal(internal) => internal.commands(),
            Self::External(_) => external::commands(session),
        }
    }

    /// A period that began at `trigger_ns` is over: what was written before TIM4's compare is now the output.
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

    /// A fault of a converter. Of these the chip's own have only that the DAC is off.
    pub fn disturb(&mut self, session: &mut Session<Nucleo>, fault: InjectedFault) {
        match self {
            Self::Internal(internal) if matches!(fault, InjectedFault::ResetLine(_)) => {
                internal.keep_charge();
            }
            Self::Internal(_) => {}
            Self::External(_) => match fault {
                InjectedFault::OutputDips => external::dip_output(session),
                InjectedFault::InputDips => external::dip_input(session),
                InjectedFault::InputScale { percent } => external::scale_input(session, percent),
                InjectedFault::InputStands => external::stand_input(session),
                InjectedFault::SlowInput => external::slow_input(session),
                InjectedFault::StuckData { high } => external::stick_data(session, high),
                InjectedFault::OpenData => external::open_data(session),
                _ => {}
            },
        }
    }

    /// A bit of the next frame from the external input converter flips.
    pub fn turn_over_input(&mut self, session: &mut Session<Nucleo>, bit: u32) {
        if let Self::External(_) = self {
            external::turn_over_input(session, bit);
        }
    }

    /// A bit of the next command to the external output converter flips.
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

/// The displacement commanded by a code, m.
pub fn command_m(wired: &Calibration, code: u16) -> f64 {
    let line = wired.command;
    (f64::from(code) - f64::from(line.zero_code)) * f64::from(line.per_code)
}

/// A sensor's code, with its fraction, for a quantity in m or N.
pub fn sensor_code(line: ChannelCalibration, quantity: f64) -> f64 {
    quantity / f64::from(line.per_code) + f64::from(line.zero_code)
}
