//! Requests from the PC to the board.

use crate::agreed::MAX_ACTUATORS;
use crate::channel::Calibration;
use heapless::Vec;
use outerloop_core::coupled::CoupledSettings;
use outerloop_core::watch::Instructions;
use outerloop_core::{Config, Event, Pace};
use serde::{Deserialize, Serialize};

/// The longest ground motion, points.
pub const MAX_POINTS: usize = 16_384;

/// Points of the ground motion per command.
pub const CHUNK: usize = 128;

/// A test as a board runs it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoardTest {
    /// What every test has.
    #[serde(with = "once")]
    pub config: Config,
    /// What a test of two coupled actuators has beside it; they are the board's first two.
    #[serde(with = "once")]
    pub coupled: Option<CoupledSettings<2>>,
}

/// Encoded as is, by one function for the link and for a board's flash: inlined in both, an image is 20 KiB larger.
mod once {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[inline(never)]
    pub fn serialize<T: Serialize, S: Serializer>(value: &T, to: S) -> Result<S::Ok, S::Error> {
        value.serialize(to)
    }

    #[inline(never)]
    pub fn deserialize<'de, T: Deserialize<'de>, D: Deserializer<'de>>(
        from: D,
    ) -> Result<T, D::Error> {
        T::deserialize(from)
    }
}

impl BoardTest {
    /// Number of participating actuators.
    pub fn actuators(&self) -> usize {
        match &self.coupled {
            Some(_) => 2,
            None => self.config.physical_storeys(),
        }
    }
}

impl From<Config> for BoardTest {
    fn from(config: Config) -> Self {
        Self {
            config,
            coupled: None,
        }
    }
}

/// A command. Postcard; the frame's sequence number is the request's number.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is no heap on the board to box a configuration in"
)]
pub enum Command {
    /// Who are you: [`Reply::Identity`](crate::Reply::Identity).
    Identify,
    /// Requests [`Reply::Status`](crate::Reply::Status). The PC asks a few times a second; that is also how the board
    /// knows that the PC is there.
    Status,
    /// Exchange the whole test, while idle.
    Configure(BoardTest),
    /// Exchange the calibration of an actuator's channels, while idle; actuators count from 0.
    Calibrate(u8, Calibration),
    /// Make the present reading of a channel the given value, by moving the channel's zero, while idle.
    Zero {
        /// Of which actuator, from 0.
        actuator: u8,
        /// Which channel.
        channel: Channel,
        /// What the reading is to be: m or N.
        value: f32,
    },
    /// Write the calibration, and the test if there is one, where they survive power-off, while idle.
    Save,
    /// A ground motion of so many points follows, while idle; what was loaded is gone.
    Motion {
        /// Number of points, at most [`MAX_POINTS`].
        points: u32,
        /// Interval of the points in model time, s.
        interval_s: f64,
        /// [`checksum`](crate::frame::checksum) of all points as little-endian bytes.
        checksum: u32,
    },
    /// Points of the ground motion, m/s^2, in order and without a gap. The last one closes the motion and is checked.
    Points {
        /// Index of the first.
        first: u32,
        /// The points.
        points: Vec<f32, CHUNK>,
    },
    /// What the next start runs: a commissioning signal, or the test.
    Signal(Option<CommissioningSignal>),
    /// Arm, start, hold, stop, clear.
    Event(Event),
    /// The loop's record of one of the last steps before a fault, 0 the oldest.
    History(u8),
    /// Where the next test's targets come from, while idle: from the PC, one by one, or from the loop's own integration.
    /// A new test integrates by itself.
    Pace(Option<Pace>),
    /// The next target from the PC, m, of each of the board's actuators: where they are to go. It replaces targets
    /// towards which the motion has not begun.
    Target(Vec<f32, MAX_ACTUATORS>),
    /// What the rig watch of an actuator, from 0, is told of the test in force, while idle. In turn; with the last one of the
    /// board's actuators the tests to come are watched, until another test is in force.
    Watch(u8, Instructions),
}

/// A channel of the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Channel {
    /// Measured displacement.
    Displacement,
    /// Measured force.
    Force,
}

/// A signal to measure an actuator with, around zero displacement; the others stand at zero. All the test's limits are in
/// force, for each of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CommissioningSignal {
    /// Which actuator it moves, from 0.
    pub actuator: u8,
    /// Its shape.
    pub shape: SignalShape,
    /// Largest displacement, m.
    pub amplitude_m: f32,
    /// Its length, s, the half second of rise and of fall included.
    pub seconds: f32,
}

/// The shape of a commissioning signal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum SignalShape {
    /// To the amplitude, and back at the end.
    Constant,
    /// A sine.
    Sine {
        /// Its frequency, Hz.
        frequency_hz: f32,
    },
    /// A sine whose frequency goes linearly from one to the other.
    Chirp {
        /// At the start, Hz.
        from_hz: f32,
        /// At the end, Hz.
        to_hz: f32,
    },
    /// The points that were sent with [`Command::Motion`] and [`Command::Points`], as displacements in m: the board goes
    /// from one to the next in a straight line. They are no ground motion any more once they were named so.
    Points,
}
