//! The emulated machine and a session with the image in it.

use crate::Shaking;
use firmware::session::{PeriodReply, PeriodRequest, SessionAccount};
use link::Decoder;
use link::command::{CHUNK, Command};
use link::frame::checksum;
use link::message::Message;
use link::reply::{NumberedReply, Reply};
use outerloop_core::watch::Instructions;
use outerloop_core::{Config, Sample};
use std::io::{Error, Read, Result, Write};
use std::path::Path;
use std::process::{self, Child, ChildStderr, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};

/// The emulator.
pub const EMULATOR: &str = "qemu-system-arm";

/// The emulator with a board of the image's processor, and the image on it.
pub fn with_image(image: &Path) -> process::Command {
    let mut command = process::Command::new(EMULATOR);
    command
        .args(["-M", "netduinoplus2", "-display", "none"])
        .args(["-serial", "none", "-monitor", "none"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .arg("-kernel")
        .arg(image);
    command
}

/// A test: configuration, ground motion, and the rig watch's instructions.
#[derive(Clone, Copy, Debug)]
pub struct Test<'a> {
    /// Configuration.
    pub config: &'a Config,
    /// Ground motion.
    pub shaking: &'a Shaking,
    /// Instructions for each actuator; empty if the test is not watched.
    pub watched: &'a [Instructions],
}

impl<'a> Test<'a> {
    /// A test that is not watched.
    pub fn new(config: &'a Config, shaking: &'a Shaking) -> Self {
        Self {
            config,
            shaking,
            watched: &[],
        }
    }

    /// The command before control period `tick`: the instructions for this actuator's watch, if there are any.
    pub fn told(&self, tick: u32) -> Option<Command> {
        let told = self.watched.get(tick as usize)?;
        Some(Command::Watch(tick as u8, told.clone()))
    }
}

/// How the emulator's clock runs and what it measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clock {
    /// As fast as possible; the image's timings mean nothing.
    Free,
    /// 8 ns an instruction: the image's timings count instructions.
    Counting,
    /// As `Counting`, one instruction at a time, each traced to standard error.
    Tracing,
}

/// A session with an image running in the emulator.
#[derive(Debug)]
pub struct Machine<const N: usize> {
    child: Child,
    decoder: Decoder,
    request: u16,
}

impl<const N: usize> Machine<N> {
    /// Starts `image`, which then waits for its test.
    ///
    /// # Errors
    /// The emulator does not start.
    pub fn start(image: &Path, clock: Clock) -> Result<Self> {
        Self::start_filtered(image, clock, None)
    }

    /// As [`Self::start`]; a trace contains only the addresses of `filter`.
    ///
    /// # Errors
    /// The emulator does not start.
    pub fn start_filtered(image: &Path, clock: Clock, filter: Option<&str>) -> Result<Self> {
        if clock != Clock::Tracing {
            share_a_processor();
        }
        let mut command = with_image(image);
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        if clock != Clock::Free {
            command.args(["-icount", "shift=3"]);
        }
        if clock == Clock::Tracing {
            command
                .args(["-d", "exec,nochain"])
                .args(one_instruction_at_a_time()?);
            if let Some(filter) = filter {
                command.args(["-dfilter", filter]);
            }
            command.stderr(Stdio::piped());
        }
        Ok(Self {
            child: command.spawn()?,
            decoder: Decoder::new(),
            request: 0,
        })
    }

    /// Gives the image its test.
    ///
    /// # Errors
    /// The image has ended, or refuses the test, in its own words.
    pub fn begin(&mut self, test: &Test<'_>) -> Result<()> {
        let points = &test.shaking.acc_m_per_s2;
        self.accepted(Command::Motion {
            points: points.len() as u32,
            interval_s: test.shaking.interval_s,
            checksum: checksum(points.iter().flat_map(|p| p.to_le_bytes())),
        })?;
        for (i, chunk) in points.chunks(CHUNK).enumerate() {
            self.accepted(Command::Points {
                first: (i * CHUNK) as u32,
                points: chunk.iter().copied().collect(),
            })?;
        }
        self.accepted(Command::Configure(test.config.clone().into()))
    }

    /// Sends a command that must be accepted.
    fn accepted(&mut self, command: Command) -> Result<()> {
        self.send(&command)?;
        match self.reply()? {
            Reply::Done { .. } => Ok(()),
            Reply::Refused(refused) => Err(Error::other(refused.to_string())),
            other => Err(Error::other(format!("the image answers {other:?}"))),
        }
    }

    fn send(&mut self, command: &Command) -> Result<()> {
        self.request = self.request.wrapping_add(1);
        let wire = command.encode(self.request);
        self.write(&wire.map_err(|_| Error::other("the command is too long"))?)
    }

    /// The reply to the last command sent.
    fn reply(&mut self) -> Result<Reply> {
        loop {
            let mut byte = [0];
            self.read(&mut byte)?;
            if let Some(frame) = self.decoder.push(byte[0]) {
                let answer = NumberedReply::decode(&frame).filter(|a| a.request == self.request);
                let answer = answer.ok_or_else(|| Error::other("the image answers out of turn"))?;
                return Ok(answer.reply);
            }
        }
    }

    /// One control period, after `command`; returns the reply and the words of the record.
    ///
    /// # Errors
    /// The image has ended, or refuses the command.
    pub fn period(
        &mut self,
        command: Option<&Command>,
        sample: Sample<N>,
    ) -> Result<(PeriodReply<N>, Vec<u32>)> {
        let request = PeriodRequest::Step {
            command: command.is_some(),
            sample,
        };
        self.write(&request.encode())?;
        if let Some(command) = command {
            self.send(command)?;
            // An event that is not valid yet is rejected, here as in this process.
            if let Reply::Refused(refused) = self.reply()? {
                return Err(Error::other(refused.to_string()));
            }
        }
        let mut bytes = vec![0; PeriodReply::<N>::BYTES];
        self.read(&mut bytes)?;
        let (output, words) = PeriodReply::decode(&bytes).map_err(malformed)?;
        Ok((output, words.collect()))
    }

    /// Ends the session; returns its account.
    ///
    /// # Errors
    /// The image has ended already, or with a failure.
    pub fn end(mut self) -> Result<SessionAccount> {
        self.write(&PeriodRequest::<N>::End.encode())?;
        let mut bytes = [0; SessionAccount::BYTES];
        self.read(&mut bytes)?;
        let status = self.child.wait()?;
        if !status.success() {
            return Err(Error::other(format!("the image ended with {status}")));
        }
        SessionAccount::decode(&bytes).map_err(malformed)
    }

    /// The emulator's trace; it must be read from the start, or the emulator blocks.
    pub fn trace(&mut self) -> Option<ChildStderr> {
        self.child.stderr.take()
    }

    fn write(&mut self, bytes: &[u8]) -> Result<()> {
        let pipe = self
            .child
            .stdin
            .as_mut()
            .ok_or_else(|| Error::other("no pipe to the image"))?;
        pipe.write_all(bytes)
    }

    fn read(&mut self, bytes: &mut [u8]) -> Result<()> {
        let pipe = self
            .child
            .stdout
            .as_mut()
            .ok_or_else(|| Error::other("no pipe from the image"))?;
        pipe.read_exact(bytes)
    }
}

impl<const N: usize> Drop for Machine<N> {
    fn drop(&mut self) {
        // Already over if the session was ended; if it will not stop, nothing can be done.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Keeps this thread, and the emulator that it starts, on one processor: the two take turns, and a wake-up on another
/// processor costs more than a control period.
fn share_a_processor() {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    let all = core_affinity::get_core_ids().unwrap_or_default();
    let turn = NEXT.fetch_add(1, Ordering::Relaxed);
    if let Some(&id) = all.get(turn % all.len().max(1)) {
        // Slower without, not wrong.
        core_affinity::set_for_current(id);
    }
}

fn malformed(_: firmware::session::Malformed) -> Error {
    Error::other("the image's message has another form")
}

/// The option had another name before QEMU 8.1.
fn one_instruction_at_a_time() -> Result<&'static [&'static str]> {
    let output = process::Command::new(EMULATOR)
        .arg("--version")
        .output()?
        .stdout;
    let text = String::from_utf8_lossy(&output);
    let mut numbers = text
        .split(|c: char| !c.is_ascii_digit())
        .filter_map(|n| n.parse::<u32>().ok());
    Ok(if (numbers.next(), numbers.next()) >= (Some(8), Some(1)) {
        &["-accel", "tcg,one-insn-per-tb=on"]
    } else {
        &["-singlestep"]
    })
}
