//! Commands and their replies, and the telemetry between them.

use super::port::{Port, Serial};
use experiment::failure::Failure;
use link::continuity::{Continuity, Ticks};
use link::frame::{Decoder, DecoderCounts, FrameKind};
use link::message::Message;
use link::reply::{NumberedReply, Reply};
use link::telemetry::StepReport;
use link::{Command, Telemetry, VERSION};
use outerloop_core::Event;
use std::collections::VecDeque;
use std::time::Duration;

/// The PC sends a heartbeat (a status request) after at most this many control steps. The board gives the PC up after
/// 0.5 s, 1000 steps at 2 kHz.
const HEARTBEAT_STEPS: u32 = 200;

/// And after at most this time, if no steps arrive.
const HEARTBEAT_INTERVAL: Duration = Duration::from_millis(100);

/// A command is repeated, under the same number, for this many times [`Timeouts::silence`].
const ATTEMPTS: u32 = 4;

/// A PC that has heard nothing for this long sends no more heartbeats. The board gives it up after as much again, and
/// brings the rig to rest. No motion is requested any more, either.
const UNSEEN: Duration = Duration::from_millis(500);

/// How long the PC waits.
#[derive(Clone, Copy, Debug)]
pub struct Timeouts {
    /// For the reply to a command, before it is sent again.
    pub answer: Duration,
    /// For the reply to an event, a target or a status request, before it is sent again: the board gives the PC up after
    /// 0.5 s.
    pub stop: Duration,
    /// For any frame: four times this without one, and the link counts as lost.
    pub silence: Duration,
}

impl Timeouts {
    /// For a board.
    pub const BOARD: Self = Self {
        answer: Duration::from_secs(1),
        stop: Duration::from_millis(40),
        silence: Duration::from_secs(1),
    };
}

/// A connection to a board.
pub struct Connection<P> {
    port: P,
    timeouts: Timeouts,
    decoder: Decoder,
    frames: Continuity,
    ticks: Ticks,
    sequence: u16,
    answers: VecDeque<NumberedReply>,
    /// A reply came that this program cannot decode: the link has the same version, the firmware is newer.
    foreign: bool,
    steps: VecDeque<(u32, StepReport)>,
    /// When the last frame came, and when the port was last read, by the port's time.
    heard: Duration,
    looked: Duration,
    last_heartbeat: Duration,
    steps_since_heartbeat: u32,
}

/// A connection to a board over any kind of port.
pub type BoardConnection = Connection<Box<dyn Port>>;

impl Connection<Serial> {
    /// With the board at this serial port.
    ///
    /// # Errors
    /// A port that cannot be opened.
    pub fn open(device: &str) -> Result<Self, Failure> {
        Ok(Self::new(Serial::open(device)?, Timeouts::BOARD))
    }
}

impl<P: Port> Connection<P> {
    /// Over `port`. Nothing is sent yet.
    pub fn new(port: P, timeouts: Timeouts) -> Self {
        let now = port.now();
        Self {
            port,
            timeouts,
            decoder: Decoder::new(),
            frames: Continuity::new(),
            ticks: Ticks::new(),
            // Must differ from the number of an earlier session's last command: the board would only repeat its reply.
            sequence: now.subsec_micros() as u16 ^ now.as_secs() as u16,
            answers: VecDeque::new(),
            foreign: false,
            steps: VecDeque::new(),
            heard: now,
            looked: now,
            last_heartbeat: now,
            steps_since_heartbeat: 0,
        }
    }

    /// Sends `command` and waits for its reply. Telemetry that comes meanwhile is kept.
    ///
    /// # Errors
    /// The link is lost, or the board is silent or of another version.
    pub fn ask(&mut self, command: &Command) -> Result<Reply, Failure> {
        // Replies to heartbeats that nobody waited for: their numbers come again after 65 536.
        self.answers.clear();
        let request = self.next_request();
        let wire = command.encode(request).map_err(|_| {
            Failure::input("the command does not fit a frame of the link: accepted are tests of up to 8 floors")
        })?;
        let urgent = matches!(
            command,
            Command::Event(_) | Command::Target(_) | Command::Status
        );
        // An urgent command is only repeated sooner, under the same number; a start or a target is also given up sooner.
        let timeout = if urgent {
            self.timeouts.stop
        } else {
            self.timeouts.answer
        };
        let moves = matches!(command, Command::Event(Event::Start) | Command::Target(_));
        let longest = if moves {
            UNSEEN
        } else {
            self.timeouts.silence * ATTEMPTS
        };
        let given_up = self.port.now() + longest;
        while self.port.now() < given_up {
            // The zero ends any partial frame on the line.
            self.send(&[0])?;
            self.send(&wire)?;
            let until = self.port.now() + timeout;
            while self.port.now() < until {
                self.receive()?;
                while let Some(answer) = self.answers.pop_front() {
                    if answer.request == request {
                        return self.refuse_unknown(answer.reply);
                    }
                }
                if let Some(version) = self.decoder.other_version() {
                    return Err(other_version(version));
                }
            }
        }
        if self.foreign {
            return Err(Failure::input(
                "the board answers with something that this program does not know, a fault with a new number for one: \
                 accepted is firmware of the same release, to be flashed with `cargo run -p firmware --release`",
            ));
        }
        Err(Failure::test(
            "the board does not answer: is this its port, has it power, and is the firmware flashed?",
        ))
    }

    /// A step of the telemetry, if there is one; sends a heartbeat when one is due.
    ///
    /// # Errors
    /// The link is lost.
    pub fn step(&mut self) -> Result<Option<(u32, StepReport)>, Failure> {
        if self.steps.is_empty() {
            self.receive()?;
        }
        self.show_life()?;
        Ok(self.steps.pop_front())
    }

    /// Keeps the telemetry that comes, and sends heartbeats when due, while the caller waits for something else.
    ///
    /// # Errors
    /// The link is lost.
    pub fn listen(&mut self) -> Result<(), Failure> {
        self.receive()?;
        self.show_life()
    }

    fn show_life(&mut self) -> Result<(), Failure> {
        if self.port.now().saturating_sub(self.heard) > UNSEEN {
            return Ok(());
        }
        if self.steps_since_heartbeat >= HEARTBEAT_STEPS
            || self.port.now().saturating_sub(self.last_heartbeat) >= HEARTBEAT_INTERVAL
        {
            self.last_heartbeat = self.port.now();
            self.steps_since_heartbeat = 0;
            let request = self.next_request();
            if let Ok(wire) = Command::Status.encode(request) {
                self.send(&wire)?;
            }
        }
        Ok(())
    }

    /// The steps received so far; waits some milliseconds if there are none.
    ///
    /// # Errors
    /// The link is lost.
    pub fn steps(&mut self) -> Result<Vec<(u32, StepReport)>, Failure> {
        let first = self.step()?;
        Ok(first.into_iter().chain(self.steps.drain(..)).collect())
    }

    /// Discards the telemetry received so far.
    pub fn forget_steps(&mut self) {
        self.steps.clear();
    }

    /// Steps of the telemetry that were received, and steps missing between them.
    pub fn counted(&self) -> (u64, u64) {
        (self.ticks.received(), self.ticks.lost())
    }

    /// Frames missing between those received, and the decoder's counts.
    pub fn frames(&self) -> (u64, DecoderCounts) {
        (self.frames.lost(), self.decoder.seen())
    }

    fn next_request(&mut self) -> u16 {
        self.sequence = self.sequence.wrapping_add(1);
        self.sequence
    }

    fn refuse_unknown(&self, reply: Reply) -> Result<Reply, Failure> {
        match reply {
            Reply::Unknown => Err(other_version(VERSION)),
            reply => Ok(reply),
        }
    }

    fn send(&mut self, bytes: &[u8]) -> Result<(), Failure> {
        self.port.write(bytes).map_err(|e| lost(&e))
    }

    fn receive(&mut self) -> Result<(), Failure> {
        let mut bytes = [0; 4096];
        let count = self.port.read(&mut bytes).map_err(|e| lost(&e))?;
        let now = self.port.now();
        // Time in which nobody read the port is not silence.
        if now.saturating_sub(self.looked) > self.timeouts.silence {
            self.heard = now;
        }
        self.looked = now;
        for &byte in bytes.get(..count).unwrap_or(&[]) {
            let Some(frame) = self.decoder.push(byte) else {
                continue;
            };
            // Only a whole frame counts: noise on an open line does not.
            self.heard = now;
            self.frames.take(frame.sequence);
            match frame.kind {
                FrameKind::Telemetry => {
                    let Some(telemetry) = Telemetry::decode(frame.body) else {
                        continue;
                    };
                    for (k, step) in (0_u32..).zip(&telemetry.steps) {
                        let tick = telemetry.first_tick.wrapping_add(k);
                        self.ticks.take(tick);
                        self.steps.push_back((tick, *step));
                        self.steps_since_heartbeat += 1;
                    }
                }
                FrameKind::Reply => match NumberedReply::decode(&frame) {
                    Some(answer) => self.answers.push_back(answer),
                    None => self.foreign = true,
                },
                FrameKind::Command => {}
            }
        }
        let silent = now.saturating_sub(self.heard);
        if silent > self.timeouts.silence * ATTEMPTS {
            return Err(Failure::test(format!(
                "the link to the board is lost: nothing that can be read came for {:.0} s",
                silent.as_secs_f64()
            )));
        }
        Ok(())
    }
}

fn lost(e: &std::io::Error) -> Failure {
    Failure::test(format!("the link to the board is lost: {e}"))
}

fn other_version(version: u8) -> Failure {
    Failure::input(format!(
        "the board speaks another version of the link ({version}, this program {VERSION}): accepted is firmware of the \
         same release, to be flashed with `cargo run -p firmware --release`"
    ))
}
