//! What goes wrong in the laboratory, and what it keeps of what it sees.

use crate::permission::Contact;
use crate::registers::Violation;
use link::MAX_ACTUATORS;

/// What can go wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InjectedFault {
    /// The displacement sensor's wire breaks: the converter stands at its upper end.
    SensorAtRail,
    /// The displacement sensor stands still.
    FrozenSensor,
    /// A burst of 2000 codes up and down on the force.
    NoiseBurst,
    /// The emergency stop is pressed.
    EmergencyStop,
    /// The serial line is cut, both ways, for so many control steps.
    LinkCut(u64),
    /// The reset button.
    Reset,
    /// The blue button is pressed, for 600 control steps.
    Button,
    /// The contact of the permission's chain is stuck.
    Chain(Contact),
    /// An external output converter stays where it is, whatever is commanded.
    DeadOutput,
    /// The supply of the external output converter goes and comes back: it is as after power-up. The chip's own: its channel
    /// is switched off.
    OutputDips,
    /// The supply of the external input converter goes and comes back: nobody resets it again.
    InputDips,
    /// The data line of the external input converter is stuck, high or low.
    StuckData {
        /// Its level.
        high: bool,
    },
    /// A word of the external input converter comes after its frame was given up.
    LateWord,
    /// The displacement transducer is dead, and the converter has its noise: its middle code, one more, one less.
    DeadSensor,
    /// The displacement transducer stands where it is, and the converter has its noise.
    StandingSensor,
    /// The load cell is dead, and the converter has its noise.
    DeadForce,
    /// The load cell stands where it is.
    FrozenForce,
    /// The load cell stands where it is, and the converter has its noise.
    StandingForce,
    /// The load cell's wire breaks: the converter stands at its upper end.
    ForceAtRail,
    /// The load cell's polarity turns over.
    ReversedForce,
    /// The displacement transducer slips by so many micrometres.
    Slip {
        /// Micrometres.
        um: i32,
    },
    /// The displacement reads so many hundredths of what it is.
    ReadingGain {
        /// Hundredths.
        percent: u32,
    },
    /// The second displacement is dead.
    DeadSecondSensor,
    /// The known voltage on the external input converter's spare input is gone.
    NoKnownVoltage,
    /// The wire that reads the command back is broken.
    ReadBackOpen,
    /// The servo valve sticks: the rig stays where it is, whatever is commanded.
    DeadValve,
    /// The servo goes to so many hundredths of where it is sent, by and by within 100 control steps.
    Gain {
        /// Hundredths.
        percent: u32,
    },
    /// The specimen is so many hundredths as stiff: the force is.
    Stiffness {
        /// Hundredths.
        percent: u32,
    },
    /// The servo becomes later by so many control steps.
    LateBy(usize),
    /// The firmware's own drill of this number, by a write into its memory as a debugger does it.
    Drill(u32),
    /// The known voltage is there in every third frame only.
    KnownVoltageFlickers,
    /// The command that is read back is there in every third frame only.
    ReadBackFlickers,
    /// The second displacement is there in every third frame only.
    SecondSensorFlickers,
    /// The force is there in every third frame only.
    ForceFlickers,
    /// The displacement is there in every third frame only.
    SensorFlickers,
    /// The force reads so many hundredths of what it is.
    ForceGain {
        /// Hundredths.
        percent: u32,
    },
    /// The servo valve is wide open by itself: the rig goes one way as fast as the valve lets it.
    Runaway {
        /// Towards the upper end.
        up: bool,
    },
    /// The wire to the servo is broken behind where the command is read back: the servo reads ground.
    CommandOpen,
    /// The reference of the external input converter is off: everything reads so many hundredths of what it is.
    InputScale {
        /// Hundredths.
        percent: u32,
    },
    /// The external input converter ends its conversions and shows the results of an earlier one.
    InputStands,
    /// The memory of the ground motion reads as ones, each point a NaN.
    LostMotion,
    /// A bit of the sampling timer's period turns over: at 2 kHz it is more than twice as long, by the timer's own count as well.
    SlowTimer,
    /// The same, a fifth shorter.
    FastTimer,
    /// The clock of port E is off: PERMIT, its pulses and the step's line stay where they are, and every pin of it reads low.
    PortWithoutClock,
    /// The force is gone for `open` control steps of every `of`.
    ForceContact {
        /// Steps without it.
        open: u64,
        /// Of so many.
        of: u64,
    },
    /// The load cell's amplifier is off by so many newtons.
    ForceOffset {
        /// Newtons.
        n: i32,
    },
    /// The load cell is dead before an amplifier that hums at 50 Hz, by so many codes to either side.
    HummingForce {
        /// Codes.
        codes: u32,
    },
    /// The external input converter takes 9 us for a conversion: its frame is read before that has ended.
    SlowInput,
    /// A bit of the exponent of a point of the ground motion turns over: of the 400 from this on that by which it is off by most, below
    /// 6 m/s^2.
    TurnedPoint {
        /// The first of them, from 0.
        from: u64,
    },
    /// The board is reset, and the external input converter's data line is dead from then on.
    ResetWithoutInput,
}

/// A fault, and for how long PERMIT has been high when it comes: with 0 it is there from the first sample on.
#[derive(Clone, Copy, Debug)]
pub struct PlannedFault {
    /// Control steps with PERMIT high.
    pub after_steps: u64,
    /// What goes wrong.
    pub fault: InjectedFault,
}

/// Something that was seen, and when, ns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoggedEvent {
    /// The PERMIT line changed.
    Permit(bool),
    /// The code of the first actuator's command was written.
    Command(u16),
    /// The planned fault came.
    Fault,
    /// The chip was reset.
    Reset,
}

/// What the laboratory keeps.
#[derive(Clone, Debug, Default)]
pub struct Log {
    /// Everything that was seen.
    pub seen: Vec<(u64, LoggedEvent)>,
    /// Instants of the conversions' triggers, ns.
    pub triggers_ns: Vec<u64>,
    /// From each trigger to the write of the command, ns.
    pub latency_ns: Vec<u32>,
    /// Of each step, from its begin to its command, instructions.
    pub step_instructions: Vec<u32>,
    /// What does not hold in the registers at the first trigger after a reset.
    pub violations: Vec<Violation>,
    /// Updates of the sampling timer.
    pub periods: usize,
    /// Codes that the first actuator's output has shown, period by period; `None` while it floats.
    pub pin: Vec<Option<u16>>,
    /// Those of the others; `None` too where there is no such actuator.
    pub other_pins: Vec<[Option<u16>; MAX_ACTUATORS - 1]>,
    /// Where the first actuator stood, period by period, m.
    pub position_m: Vec<f64>,
    /// PERMIT's level, period by period.
    pub permitted: Vec<bool>,
}
