//! Replies from the board.

use crate::agreed::MAX_ACTUATORS;
use crate::channel::{Calibration, CodeRange, number_of};
use crate::status::Status;
use crate::telemetry::{Input, MAX_INPUTS};
use heapless::{String, Vec};
use outerloop_core::{Event, Fault, Mode, Refusal, Rejected};
use serde::{Deserialize, Serialize};

/// Words of the record of a loop with three degrees of freedom, the most that a board runs.
pub const MAX_RECORD: usize = outerloop_core::Record::<3>::WORDS;

/// A reply, with the number of the request it answers. Postcard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NumberedReply {
    /// Sequence number of the command.
    pub request: u16,
    /// The answer to it.
    pub reply: Reply,
}

/// What the answer can be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "without a heap nothing can be boxed"
)]
pub enum Reply {
    /// Who the board is.
    Identity(Identity),
    /// How it is.
    Status(Status),
    /// Done. From the control step with this tick on it is in force.
    Done {
        /// The first control step with it.
        tick: u32,
        /// The mode after it.
        mode: Mode,
    },
    /// A parameter is not accepted; nothing has changed.
    Refused(RefusedParameter),
    /// The event or command means nothing in this mode, or an interlock stands against it; nothing has changed.
    Rejected {
        /// The mode.
        mode: Mode,
        /// The event, if it was one.
        event: Option<Event>,
        /// The interlock.
        obstacle: Option<Obstacle>,
    },
    /// The channel's zero was moved.
    Zeroed {
        /// Mean code over the reading.
        code: f32,
        /// Largest less smallest code in it.
        spread: u16,
    },
    /// A record, word for word; empty if there is none of this number.
    Record(Vec<u32, MAX_RECORD>),
    /// A chunk of the ground motion that does not go on where the last one ended; the point that is expected.
    Expected(u32),
    /// The ground motion's check sum does not fit; it is not loaded.
    WrongSum {
        /// Of what arrived.
        received: u32,
    },
    /// The frame was good and the command was not: another version of this crate.
    Unknown,
}

/// What stands against arming.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Obstacle {
    /// An interlock of the loop.
    Fault(Fault),
    /// Nobody has calibrated the board's channels.
    NotCalibrated,
    /// No configuration has been accepted since power-up and none was kept.
    NotConfigured,
    /// No ground motion is loaded and no commissioning signal is set.
    NothingToRun,
    /// The crystal does not have the frequency that the clocks are worked out from.
    Crystal,
    /// A converter outside the chip did not answer when the board started.
    Converters,
}

/// What [`Event::Arm`] or [`Event::Start`] also demands: refused by its [`name`](Self::name), as a [`RefusedParameter`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NotReady {
    /// The hold button is pressed.
    Held,
    /// The loop integrates, but no energy error would stop it.
    NoEnergyTrip,
    /// A test starts at rest, but an actuator bears a force.
    Strained,
}

impl NotReady {
    /// The name of what is refused.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Held => "the hold button",
            Self::NoEnergyTrip => "limits.energy_trip",
            Self::Strained => "the force at the start, N",
        }
    }

    const fn accepted(self) -> &'static str {
        match self {
            Self::Held => {
                "one that is not pressed, before anything is armed, is started or goes on"
            }
            Self::NoEnergyTrip => {
                "an energy error, relative to the energy in the test, that stops a test which the loop integrates: 3 is sound"
            }
            Self::Strained => {
                "what half of limits.force_stands_m makes; `board calibrate --zero force=0`, or rig.force_offset_n is not this cell's"
            }
        }
    }
}

/// A refusal with its text, as it travels.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RefusedParameter {
    /// Name of the parameter as in the test file.
    pub name: String<48>,
    /// The value that was given.
    pub value: f64,
    /// What would be accepted.
    pub accepted: String<120>,
}

impl RefusedParameter {
    /// Builds one from its parts, truncating texts that do not fit.
    pub fn new(name: &str, value: f64, accepted: &str) -> Self {
        Self {
            name: cut(name),
            value,
            accepted: cut(accepted),
        }
    }

    /// Whether this is what stands against arming or starting.
    pub fn is(&self, what: NotReady) -> bool {
        self.name == what.name()
    }
}

impl From<(NotReady, f64)> for RefusedParameter {
    fn from((what, value): (NotReady, f64)) -> Self {
        Self::new(what.name(), value, what.accepted())
    }
}

impl From<Refusal> for RefusedParameter {
    fn from(r: Refusal) -> Self {
        Self::new(r.name, r.value, r.accepted)
    }
}

impl From<Refusal> for Reply {
    fn from(r: Refusal) -> Self {
        Self::Refused(r.into())
    }
}

impl From<Rejected> for Reply {
    fn from(r: Rejected) -> Self {
        Self::Rejected {
            mode: r.mode,
            event: Some(r.event),
            obstacle: r.obstacle.map(Obstacle::Fault),
        }
    }
}

impl core::fmt::Display for RefusedParameter {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}", self.name)?;
        if !self.value.is_nan() {
            write!(f, " = {}", self.value)?;
        }
        write!(
            f,
            " is refused by the board: accepted are {}",
            self.accepted
        )
    }
}

/// As much of `text` as fits, whole characters only.
pub fn cut<const N: usize>(text: &str) -> String<N> {
    let mut out = String::new();
    for c in text.chars() {
        if out.push(c).is_err() {
            break;
        }
    }
    out
}

/// Who the board is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Identity {
    /// Its name.
    #[cfg_attr(feature = "schema", schemars(with = "str"))]
    pub board: String<24>,
    /// Version of the firmware.
    #[cfg_attr(feature = "schema", schemars(with = "str"))]
    pub version: String<16>,
    /// Commit that it was built from, `-dirty` behind it if it was not that commit.
    #[cfg_attr(feature = "schema", schemars(with = "str"))]
    pub commit: String<24>,
    /// Processor clock, Hz.
    pub clock_hz: u32,
    /// Clock of the sampling timer, Hz; a control rate must divide it.
    pub timer_hz: u32,
    /// Control rate in force, Hz.
    pub rate_hz: u32,
    /// The fastest control rate whose telemetry the port carries, Hz.
    pub fastest_rate_hz: u32,
    /// From the sampling trigger to the instant at which the command leaves the converter, us.
    pub output_delay_us: f32,
    /// Longest ground motion, points.
    pub max_points: u32,
    /// Most degrees of freedom.
    pub max_dof: u8,
    /// Cycles of the processor that a step may take up to its command.
    pub deadline_cycles: u32,
    /// Widths of the converters' codes.
    pub codes: CodeRange,
    /// The calibration in force, of the first actuator.
    pub calibration: Calibration,
    /// Those of the other actuators: as many as the board has beside the first.
    #[cfg_attr(feature = "schema", schemars(with = "[Calibration]"))]
    pub others: Vec<Calibration, { MAX_ACTUATORS - 1 }>,
    /// What is recorded beside displacement and force, in the order of the telemetry.
    #[cfg_attr(feature = "schema", schemars(with = "[Input]"))]
    pub inputs: Vec<Input, MAX_INPUTS>,
    /// Volts at the ends of the further inputs' codes; of a command read back its codes are those of the command.
    pub input_span_v: [f32; 2],
}

impl Identity {
    /// Number of actuators.
    pub fn actuators(&self) -> usize {
        1 + self.others.len()
    }

    /// The calibration of each actuator.
    pub fn calibrations(&self) -> impl Iterator<Item = &Calibration> + Clone {
        core::iter::once(&self.calibration).chain(&self.others)
    }

    /// The number of the whole board's calibration, see [`number_of`].
    pub fn calibration_number(&self) -> u32 {
        number_of(self.calibrations())
    }
}
