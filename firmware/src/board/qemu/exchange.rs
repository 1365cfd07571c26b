//! The PC as the board's port and converters: commands and samples come from its pipe, replies and commands go to it.

use super::semihosting::{self, File, HostGone};
use crate::session::{Malformed, Message, PeriodReply, PeriodRequest, SessionAccount};
use crate::station::upload::{Upload, Uploaded};
use link::message::Message as _;
use link::reply::{NumberedReply, RefusedParameter, Reply};
use link::{Command, Decoder};
use outerloop_core::{Config, Mode, Record, Sample};

impl From<Malformed> for HostGone {
    fn from(_: Malformed) -> Self {
        Self
    }
}

/// The start of a session; the command that brought it still awaits its reply.
pub struct Begin {
    /// Number of that command.
    pub request: u16,
    /// The test.
    pub config: Config,
    /// Points of the ground motion.
    pub points: usize,
    /// Interval of the points, s.
    pub interval_s: f64,
}

/// Both ends of the pipe: standard input and output of the emulator.
pub struct Exchange {
    from_pc: File,
    to_pc: File,
    decoder: Decoder,
    replies: u16,
}

impl Exchange {
    /// Opens the pipe.
    ///
    /// # Errors
    /// The host does not grant access to its standard input and output.
    pub fn open() -> Result<Self, HostGone> {
        Ok(Self {
            from_pc: File::open(c"/dev/stdin", semihosting::Mode::Read)?,
            to_pc: File::open(c"/dev/stdout", semihosting::Mode::Write)?,
            decoder: Decoder::new(),
            replies: 0,
        })
    }

    /// Waits for a command; returns it with its number.
    ///
    /// # Errors
    /// The PC has disappeared.
    pub fn command(&mut self) -> Result<(u16, Command), HostGone> {
        loop {
            let mut byte = [0; 1];
            self.from_pc.read(&mut byte)?;
            let [byte] = byte;
            if let Some(frame) = self.decoder.push(byte) {
                let (request, command) = (frame.sequence, Command::received(&frame));
                match command {
                    Ok(command) => return Ok((request, command)),
                    Err(why) => self.reply(request, why.into())?,
                }
            }
        }
    }

    /// Answers the command with this number.
    ///
    /// # Errors
    /// The PC has disappeared.
    pub fn reply(&mut self, request: u16, reply: Reply) -> Result<(), HostGone> {
        let answer = NumberedReply { request, reply };
        let wire = answer.encode(self.replies).map_err(|_| HostGone)?;
        self.replies = self.replies.wrapping_add(1);
        self.to_pc.write(&wire)
    }

    /// Receives a ground motion into `memory`, m/s^2, until the configuration follows.
    ///
    /// # Errors
    /// The PC has disappeared.
    pub fn begin(&mut self, memory: &mut [f32]) -> Result<Begin, HostGone> {
        let (mut upload, mut whole) = (None, None);
        loop {
            let (request, command) = self.command()?;
            let reply = match (command, &mut upload, &whole) {
                (Command::Configure(test), _, Some(motion)) if test.coupled.is_none() => {
                    let motion: &Upload = motion;
                    return Ok(Begin {
                        request,
                        config: test.config,
                        points: motion.count(),
                        interval_s: motion.interval_s(),
                    });
                }
                (Command::Motion { points, .. }, ..) if points as usize > memory.len() => {
                    let accepted = "what the emulated machine has memory for";
                    let points = f64::from(points);
                    Reply::Refused(RefusedParameter::new("motion.points", points, accepted))
                }
                (
                    Command::Motion {
                        points,
                        interval_s,
                        checksum,
                    },
                    ..,
                ) => match Upload::new(points, interval_s, checksum) {
                    Ok(begun) => {
                        upload = Some(begun);
                        Uploaded::Part.reply(0, Mode::Idle)
                    }
                    Err(refusal) => refusal.into(),
                },
                (Command::Points { first, points }, Some(upload), _) => {
                    let uploaded = upload.take(memory, first, &points);
                    whole = (uploaded == Uploaded::Whole).then_some(*upload);
                    uploaded.reply(0, Mode::Idle)
                }
                _ => Reply::Unknown,
            };
            self.reply(request, reply)?;
        }
    }

    /// Waits for the next order: whether a command follows, and the sample; `None` at the end of the session.
    ///
    /// # Errors
    /// The PC has disappeared or the order is invalid.
    pub fn period<const N: usize>(&mut self) -> Result<Option<(bool, Sample<N>)>, HostGone> {
        let mut bytes = Message::new();
        bytes
            .resize_default(PeriodRequest::<N>::BYTES)
            .map_err(|_| HostGone)?;
        self.from_pc.read(&mut bytes)?;
        Ok(match PeriodRequest::decode(&bytes)? {
            PeriodRequest::End => None,
            PeriodRequest::Step { command, sample } => Some((command, sample)),
        })
    }

    /// The result of the order.
    ///
    /// # Errors
    /// The PC has disappeared.
    pub fn output<const N: usize>(
        &mut self,
        output: &PeriodReply<N>,
        record: &Record<N>,
    ) -> Result<(), HostGone> {
        self.to_pc.write(&output.encode(record))
    }

    /// Closes the session.
    ///
    /// # Errors
    /// The PC has disappeared.
    pub fn end(&mut self, summary: &SessionAccount) -> Result<(), HostGone> {
        self.to_pc.write(&summary.encode())
    }
}
