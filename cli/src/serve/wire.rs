//! What OpenSees' element `genericClient` sends and receives: TCP, doubles and 32-bit integers in the sender's byte order
//! (little endian on every machine that it is built for). Observed with OpenSeesPy 3.7; the source is
//! `SRC/element/generic/GenericClient.cpp` and `SRC/actor/channel/TCP_Socket.cpp` of OpenSees.
//!
//! 1. Eleven integers: sizes of what it controls (displacement, velocity, acceleration, force, time), sizes of what it
//!    measures (the same five), and the length `n` of every message after that.
//! 2. Messages of `n` doubles; the first is the [`Action`].

#[cfg(target_os = "linux")]
use socket2::SockRef;
use std::fmt;
use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

/// Integers of the first message.
const HEADER: usize = 11;
/// The first message, bytes.
pub const FIRST_MESSAGE: usize = 4 * HEADER;
/// The longest accepted message, doubles: the client's default is 256.
const LONGEST: i32 = 65_536;

/// What a message requests.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// The response of a trial follows; no reply.
    Trial,
    /// The step is accepted; no reply.
    Commit,
    /// The displacement reached.
    Displacement,
    /// The force at the trial.
    Force,
    /// The time of the trial.
    Time,
    /// The initial stiffness.
    InitialStiffness,
    /// The tangent stiffness.
    TangentStiffness,
    /// The damping matrix.
    Damping,
    /// The mass matrix.
    Mass,
    /// The end.
    End,
}

impl Action {
    /// True if the client waits for a reply.
    fn is_answered(self) -> bool {
        !matches!(self, Self::Trial | Self::Commit | Self::End)
    }

    /// From the number on the wire.
    fn of(number: f64) -> Option<Self> {
        Some(match number {
            3.0 => Self::Trial,
            5.0 => Self::Commit,
            7.0 => Self::Displacement,
            10.0 => Self::Force,
            11.0 => Self::Time,
            12.0 => Self::InitialStiffness,
            13.0 => Self::TangentStiffness,
            14.0 => Self::Damping,
            15.0 => Self::Mass,
            99.0 => Self::End,
            _ => return None,
        })
    }
}

/// A message.
#[derive(Clone, Debug, PartialEq)]
pub struct ClientMessage {
    /// What it requests.
    pub action: Action,
    /// The trial response, if it is one.
    pub trial: Option<TrialResponse>,
}

/// The response of a trial, in the client's units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialResponse {
    /// Displacement of each degree of freedom.
    pub displacement: Vec<f64>,
    /// Model time, s.
    pub time_s: f64,
}

/// Why a client sends nothing more.
#[derive(Clone, Debug, PartialEq)]
pub enum ClientGone {
    /// It closed the connection, after this many bytes of a message.
    Closed(usize),
    /// The connection broke.
    Broken(String),
    /// It was silent for more than this many seconds, after this many bytes of a message.
    Silent(f64, usize),
    /// It connected but did not send its first message within this many seconds.
    Speechless(f64),
    /// It sent something that cannot be understood.
    Nonsense(String),
}

impl fmt::Display for ClientGone {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let half = |bytes: &usize| match bytes {
            0 => String::new(),
            n => format!(", {n} bytes into a message"),
        };
        match self {
            Self::Closed(bytes) => write!(
                f,
                "the client closed the connection without its last message{}",
                half(bytes)
            ),
            Self::Broken(why) => write!(f, "the connection broke: {why}"),
            Self::Silent(seconds, bytes) => write!(
                f,
                "the client said nothing for {seconds} s{}: accepted are {seconds} s at most (serve.timeout_s)",
                half(bytes)
            ),
            Self::Speechless(seconds) => write!(
                f,
                "the client said nothing for {seconds} s after it had connected: accepted is a genericClient, whose first \
                 message comes at once"
            ),
            Self::Nonsense(what) => f.write_str(what),
        }
    }
}

/// The sizes that a client has announced.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sizes {
    /// Displacements in a message; they follow the action.
    axes: usize,
    /// Index of the time.
    time: usize,
    /// Doubles of a message.
    message: usize,
}

impl Sizes {
    /// Reads the eleven integers, for a rig of `axes` degrees of freedom.
    fn of(header: &[i32; HEADER], axes: usize) -> Result<Self, String> {
        let [displacement, velocity, acceleration, force, time, ..] = *header;
        let (control, length) = (&header[..5], header[HEADER - 1]);
        if header[..HEADER - 1]
            .iter()
            .any(|s| !(0..=LONGEST).contains(s))
            || !(1..=LONGEST).contains(&length)
        {
            return Err(format!(
                "the first message {header:?} is none of OpenSees' genericClient: accepted are ten sizes and the length of a message"
            ));
        }
        if displacement as usize != axes {
            return Err(format!(
                "the client controls {displacement} displacements and the rig has {axes}: accepted is one for each storey in the laboratory"
            ));
        }
        if time != 1 {
            return Err(
                "the client sends no time: accepted is a genericClient, which sends displacement, velocity, acceleration and time"
                    .into(),
            );
        }
        let needed = 1 + control.iter().sum::<i32>().max((axes * axes) as i32);
        if length < needed {
            return Err(format!(
                "the client's messages of {length} numbers are too short: accepted are {needed} and more (-dataSize)"
            ));
        }
        Ok(Self {
            axes,
            time: (1 + displacement + velocity + acceleration + force) as usize,
            message: length as usize,
        })
    }
}

/// A connection to a client.
pub struct ClientConnection {
    stream: TcpStream,
    sizes: Sizes,
    bytes: Vec<u8>,
    filled: usize,
    heard: Instant,
    timeout: Duration,
    /// The client waits for a reply.
    owes: bool,
}

/// How long a read waits before the rig is serviced.
const SHORT_WAIT: Duration = Duration::from_millis(1);
/// How long a read waits if the rig needs no servicing.
const REST: Duration = Duration::from_millis(50);
/// Longest time for the first message, s.
const FIRST_MESSAGE_S: f64 = 5.0;

/// Longest time for the first message of a client that may later be silent for `timeout_s`, s.
pub fn first_message_s(timeout_s: f64) -> f64 {
    FIRST_MESSAGE_S.min(timeout_s)
}

impl ClientConnection {
    /// Takes a connection that was accepted at the time `at`, and receives its first message. `meanwhile` is called while
    /// nothing comes.
    ///
    /// # Errors
    /// Why there is no message.
    pub fn open<E: From<ClientGone>>(
        (stream, at): (TcpStream, Instant),
        axes: usize,
        timeout_s: f64,
        mut meanwhile: impl FnMut() -> Result<(), E>,
    ) -> Result<Self, E> {
        let broken = |e: std::io::Error| ClientGone::Broken(e.to_string());
        stream.set_nodelay(true).map_err(broken)?;
        stream.set_read_timeout(Some(REST)).map_err(broken)?;
        let mut wire = Self {
            stream,
            sizes: Sizes {
                axes,
                time: 0,
                message: 0,
            },
            bytes: vec![0; FIRST_MESSAGE],
            filled: 0,
            heard: Instant::now(),
            timeout: Duration::MAX,
            owes: false,
        };
        let first_s = first_message_s(timeout_s);
        // The limit is for the whole message, even if it comes byte by byte.
        while !wire.receive()? {
            if at.elapsed().as_secs_f64() > first_s {
                return Err(ClientGone::Speechless(first_s).into());
            }
            meanwhile()?;
        }
        wire.timeout = Duration::from_secs_f64(timeout_s);
        let mut header = [0; HEADER];
        for (number, bytes) in header.iter_mut().zip(wire.bytes.as_chunks::<4>().0) {
            *number = i32::from_le_bytes(*bytes);
        }
        wire.sizes = Sizes::of(&header, axes).map_err(ClientGone::Nonsense)?;
        wire.bytes = vec![0; 8 * wire.sizes.message];
        wire.filled = 0;
        Ok(wire)
    }

    /// Sets how long a read waits; `often`: the rig must be serviced while waiting.
    ///
    /// # Errors
    /// The connection is broken.
    pub fn set_poll_interval(&mut self, often: bool) -> Result<(), ClientGone> {
        let wait = if often { SHORT_WAIT } else { REST };
        self.stream
            .set_read_timeout(Some(wait))
            .map_err(|e| ClientGone::Broken(e.to_string()))
    }

    /// The next message; `None` if it is not complete yet.
    ///
    /// # Errors
    /// Why none will come.
    pub fn next_message(&mut self) -> Result<Option<ClientMessage>, ClientGone> {
        if !self.receive()? {
            return Ok(None);
        }
        self.filled = 0;
        let at = |place: usize| {
            let (numbers, _) = self.bytes.as_chunks::<8>();
            f64::from_le_bytes(numbers[place])
        };
        let number = at(0);
        let action = Action::of(number).ok_or_else(|| {
            ClientGone::Nonsense(format!(
                "the client asks for action {number}: accepted are 3, 5, 7, 10 to 15 and 99 of OpenSees' genericClient, in messages of {} numbers",
                self.sizes.message
            ))
        })?;
        self.owes = action.is_answered();
        let trial = (action == Action::Trial).then(|| TrialResponse {
            displacement: (1..=self.sizes.axes).map(at).collect(),
            time_s: at(self.sizes.time),
        });
        Ok(Some(ClientMessage { action, trial }))
    }

    /// Replies with `values`; the rest of the message is zero.
    ///
    /// # Errors
    /// The connection is broken.
    pub fn answer(&mut self, values: &[f64]) -> Result<(), ClientGone> {
        self.owes = false;
        let mut bytes = vec![0; 8 * self.sizes.message];
        for (place, value) in bytes.as_chunks_mut::<8>().0.iter_mut().zip(values) {
            *place = value.to_le_bytes();
        }
        // Silence is counted from the reply on: the rig may have taken longer than the client may.
        self.heard = Instant::now();
        self.stream
            .write_all(&bytes)
            .map_err(|e| ClientGone::Broken(e.to_string()))
    }

    /// True if the client waits for a reply.
    pub fn owes_an_answer(&self) -> bool {
        self.owes
    }

    /// Replies with a message full of NaN.
    ///
    /// # Errors
    /// The connection is broken.
    pub fn answer_nan(&mut self) -> Result<(), ClientGone> {
        self.answer(&vec![f64::NAN; self.sizes.message])
    }

    /// From now on the client may be silent for `seconds`.
    pub fn set_timeout(&mut self, seconds: f64) {
        self.heard = Instant::now();
        self.timeout = Duration::from_secs_f64(seconds);
    }

    /// True if a message is complete.
    fn receive(&mut self) -> Result<bool, ClientGone> {
        // Without this, client and kernel wait for each other, 45 ms a step. It holds for one read only; where it does
        // not exist only speed is lost.
        #[cfg(target_os = "linux")]
        let _ = SockRef::from(&self.stream).set_tcp_quickack(true);
        match self.stream.read(&mut self.bytes[self.filled..]) {
            Ok(0) => Err(ClientGone::Closed(self.filled)),
            Ok(count) => {
                self.filled += count;
                self.heard = Instant::now();
                Ok(self.filled == self.bytes.len())
            }
            Err(e) if waits(e.kind()) && self.heard.elapsed() < self.timeout => Ok(false),
            Err(e) if waits(e.kind()) => {
                Err(ClientGone::Silent(self.timeout.as_secs_f64(), self.filled))
            }
            Err(e) if e.kind() == ErrorKind::ConnectionReset => {
                Err(ClientGone::Closed(self.filled))
            }
            Err(e) => Err(ClientGone::Broken(e.to_string())),
        }
    }
}

/// True if a later attempt may succeed.
pub(super) fn waits(kind: ErrorKind) -> bool {
    matches!(
        kind,
        ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_message_says_where_everything_is() {
        let seen = [1, 1, 1, 0, 1, 0, 0, 0, 1, 0, 256];
        let sizes = Sizes::of(&seen, 1).unwrap();
        assert_eq!((sizes.axes, sizes.time, sizes.message), (1, 4, 256));
        let three = [3, 3, 3, 0, 1, 0, 0, 0, 3, 0, 256];
        assert_eq!(Sizes::of(&three, 3).unwrap().time, 10);
        for (header, said) in [
            (three, "controls 3 displacements and the rig has 1"),
            ([1, 1, 1, 0, 1, 0, 0, 0, 1, 0, 3], "too short"),
            ([1, 1, 1, 0, 0, 0, 0, 0, 1, 0, 256], "no time"),
            ([-1; 11], "is none of OpenSees'"),
            ([1, 1, 1, 0, 1, 0, 0, 0, 1, 0, i32::MAX], "is none of"),
        ] {
            let e = Sizes::of(&header, 1).unwrap_err();
            assert!(e.contains(said) && !e.contains('\n'), "{e}");
        }
    }
}
