//! Faults of the laboratory, and its log.

use crate::permission::Contact;
use crate::registers::{ResetLine, Violation};
use link::MAX_ACTUATORS;

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InjectedFault {
    /// The displacement sensor's wire breaks: the converter reads its highest code.
    SensorAtRail,
    /// The displacement reading freezes.
    FrozenSensor,
    /// Noise on the force, up and down by 2000/4095 of the converter's range.
    NoiseBurst,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The serial line is cut both ways for this number of control steps.
    LinkCut(u64),
    /// The reset button.
    Reset,
    /// The blue button is pressed, for 600 control steps.
    Button,
    /// The contact of the permission chain fails.
    Chain(Contact),
    /// The output stays where it is, whatever is commanded.
    DeadOutput,
    /// The supply of the external output converter fails and returns: it is as after power-up. No effect on the chip's own
    /// converters.
    OutputDips,
    /// The supply of the external input converter fails and returns, without a reset.
    InputDips,
    /// The data line of the external input converter is stuck, high or low.
    StuckData {
        /// Its level.
        high: bool,
    },
    /// The data line of the external input converter is open: pulled low, with the last two bits of each word turned at random
    /// by its neighbours' edges.
    OpenData,
    /// A word of the external input converter arrives after its frame was given up.
    LateWord,
    /// The displacement transducer is dead; the converter reads its middle code with noise of one code.
    DeadSensor,
    /// The displacement reading freezes, with the converter's noise.
    StandingSensor,
    /// The load cell is dead; the converter reads its middle code with its noise.
    DeadForce,
    /// The force reading freezes.
    FrozenForce,
    /// The force reading freezes, with the converter's noise.
    StandingForce,
    /// The load cell's wire breaks: the converter reads its highest code.
    ForceAtRail,
    /// The load cell's polarity reverses.
    ReversedForce,
    /// The displacement transducer slips.
    Slip {
        /// Micrometres.
        um: i32,
    },
    /// The displacement reading is scaled.
    ReadingGain {
        /// Percent of the true value.
        percent: u32,
    },
    /// The second displacement is dead.
    DeadSecondSensor,
    /// The known voltage on the external input converter's spare input is missing.
    NoKnownVoltage,
    /// The wire for reading the command back is broken.
    ReadBackOpen,
    /// The servo valve sticks: the actuator stays where it is, whatever is commanded.
    DeadValve,
    /// The servo's gain changes, gradually within 100 control steps.
    Gain {
        /// Percent of the command.
        percent: u32,
    },
    /// The specimen's stiffness changes: the force is scaled.
    Stiffness {
        /// Percent of the original.
        percent: u32,
    },
    /// The servo's delay grows by this number of control steps.
    LateBy(usize),
    /// The firmware's own drill of this number, started by a write into its memory as a debugger does it.
    Drill(u32),
    /// The known voltage is present only in every third frame.
    KnownVoltageFlickers,
    /// The command read back is present only in every third frame.
    ReadBackFlickers,
    /// The second displacement is present only in every third frame.
    SecondSensorFlickers,
    /// The force is present only in every third frame.
    ForceFlickers,
    /// The displacement is present only in every third frame.
    SensorFlickers,
    /// The force reading is scaled.
    ForceGain {
        /// Percent of the true value.
        percent: u32,
    },
    /// The servo valve opens fully by itself: the actuator moves one way at the valve's limit.
    Runaway {
        /// Towards the upper end.
        up: bool,
    },
    /// The wire to the servo is broken after the point where the command is read back: the servo reads ground.
    CommandOpen,
    /// The reference of the external input converter is wrong: every reading is scaled.
    InputScale {
        /// Percent of the true value.
        percent: u32,
    },
    /// The external input converter ends its conversions but repeats the results of an earlier one.
    InputStands,
    /// The memory of the ground motion is all ones: each point is a NaN.
    LostMotion,
    /// A bit of the sampling timer's period flips: at 2 kHz it is more than twice as long, also by the timer's own count.
    SlowTimer,
    /// The same, a fifth shorter.
    FastTimer,
    /// The clock of port E is off: PERMIT, its pulses and the step's line keep their levels, and every pin of the port reads low.
    PortWithoutClock,
    /// A reset line inside the chip is pulsed: its peripheral is as after power-up.
    ResetLine(ResetLine),
    /// The force is missing for `open` of every `of` control steps.
    ForceContact {
        /// Steps without it.
        open: u64,
        /// Steps in a cycle.
        of: u64,
    },
    /// The load cell's amplifier has an offset.
    ForceOffset {
        /// Newtons.
        n: i32,
    },
    /// The load cell is dead, and its amplifier hums at 50 Hz.
    HummingForce {
        /// Amplitude, codes.
        codes: u32,
    },
    /// The external input converter takes 9 us for a conversion: its frame is read before the end.
    SlowInput,
    /// An exponent bit of a point of the ground motion flips: of 400 points, the one that gives the largest error below 6 m/s^2.
    TurnedPoint {
        /// The first of the 400, from 0.
        from: u64,
    },
    /// The board is reset, and the external input converter's data line is dead from then on.
    ResetWithoutInput,
}

/// A fault, and how long PERMIT has been high when it comes: with 0 it is present from the first sample.
#[derive(Clone, Copy, Debug)]
pub struct PlannedFault {
    /// Control steps with PERMIT high.
    pub after_steps: u64,
    /// The fault.
    pub fault: InjectedFault,
}

/// A logged event.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoggedEvent {
    /// The PERMIT line changed.
    Permit(bool),
    /// The code of the first actuator's command was written.
    Command(u16),
    /// A planned fault came.
    Fault,
    /// The chip was reset.
    Reset,
}

/// The laboratory's log.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// Events, with their times, ns.
    pub seen: Vec<(u64, LoggedEvent)>,
    /// Times of the conversions' triggers, ns.
    pub triggers_ns: Vec<u64>,
    /// From each trigger to the write of the command, ns.
    pub latency_ns: Vec<u32>,
    /// Instructions of each step, from its start to its command.
    pub step_instructions: Vec<u32>,
    /// Register demands not met at the first trigger after each reset.
    pub violations: Vec<Violation>,
    /// Updates of the sampling timer.
    pub periods: usize,
    /// Codes of the first actuator's output, period by period; `None` while it floats.
    pub pin: Vec<Option<u16>>,
    /// Those of the others; also `None` where there is no such actuator.
    pub other_pins: Vec<[Option<u16>; MAX_ACTUATORS - 1]>,
    /// Position of the first actuator, period by period, m.
    pub position_m: Vec<f64>,
    /// PERMIT's level, period by period.
    pub permitted: Vec<bool>,
}
