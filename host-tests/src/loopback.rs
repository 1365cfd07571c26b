//! The firmware's simulated board behind the link's frames, with a simulated rig behind its converters: what a PC sees of a
//! board, in this process and in one thread. Each read advances the board by some steps.

use firmware::sim::{Bench, CLOCK, Plant};
use firmware::station::{Heartbeat, Report};
use link::frame::{Decoder, Frame, FrameKind, checksum};
use link::message::Message;
use link::reply::NumberedReply;
use link::telemetry::STEPS;
use link::{Command, Telemetry};
use outerloop_cli::board::Port;
use plant::Rig;
use plant::coupled::CoupledRig;
use std::collections::VecDeque;
use std::io;
use std::time::Duration;

/// What is behind a board's converters.
pub trait Laboratory<const A: usize> {
    /// One control period under these commands, m: displacement, m, and force, N, of each actuator.
    fn period(&mut self, command_m: [f64; A]) -> [[f64; 2]; A];
}

impl<const A: usize> Laboratory<A> for Rig {
    fn period(&mut self, command_m: [f64; A]) -> [[f64; 2]; A] {
        let reading = self.step(&command_m);
        std::array::from_fn(|a| [reading.displacement_m[a], reading.force_n[a]])
    }
}

/// The first two of three actuators hold a coupler; the third has no load.
impl Laboratory<3> for CoupledRig {
    fn period(&mut self, [first_m, second_m, _]: [f64; 3]) -> [[f64; 2]; 3] {
        let reading = self.step([first_m, second_m]);
        let of = |i: usize| [reading.stroke_m[i], reading.force_n[i]];
        [of(0), of(1), [0.0; 2]]
    }
}

/// A simulated rig with `A` actuators that is blocked where it is while PERMIT is low.
pub struct BlockedRig<const A: usize = 1> {
    rig: Box<dyn Laboratory<A>>,
    stands_at_m: [f64; A],
}

impl<const A: usize> Plant<A> for BlockedRig<A> {
    fn step(&mut self, command_m: [f64; A], permit: bool) -> [[f64; 2]; A] {
        let command_m = if permit { command_m } else { self.stands_at_m };
        let reading = self.rig.period(command_m);
        if permit {
            self.stands_at_m = reading.map(|[displacement_m, _]| displacement_m);
        }
        reading
    }
}

/// A frame as a build of another version of the link sends it.
pub fn of_version(version: u8, frame: &Frame<'_>) -> Vec<u8> {
    let [low, high] = frame.sequence.to_le_bytes();
    let mut plain = vec![version, frame.kind as u8, low, high];
    plain.extend(frame.body);
    plain.extend(checksum(plain.iter().copied()).to_le_bytes());
    let mut wire = vec![0; plain.len() + plain.len() / 254 + 2];
    let coded = cobs::encode(&plain, &mut wire);
    wire.truncate(coded);
    wire.push(0);
    wire
}

/// A command as a program of another version of the link sends it; the command itself is the same in both.
///
/// # Panics
/// No command is too long for it.
pub fn command_of_version(version: u8, command: &Command) -> Vec<u8> {
    let body = postcard::to_stdvec(command).expect("a command has bytes");
    let frame = Frame {
        kind: FrameKind::Command,
        sequence: 77,
        body: &body,
    };
    of_version(version, &frame)
}

/// A fault that is injected after some steps.
pub type FaultInjection<const A: usize = 1> = Box<dyn FnMut(&mut Loopback<A>)>;

/// A board at the other end of a port.
pub struct Loopback<const A: usize = 1> {
    /// The board, its tasks and its rig.
    pub board: Bench<BlockedRig<A>, A>,
    decoder: Decoder,
    commands: VecDeque<(u16, Command)>,
    sequence: u16,
    batch: Telemetry,
    out: VecDeque<u8>,
    /// Control steps since power-up.
    pub steps: u64,
    /// Duration of these steps by the board's clock.
    elapsed: Duration,
    /// Number of telemetry frames to drop on the line from now on.
    pub drop_frames: usize,
    /// Number of steps whose digest has a wrong bit from now on, as if the board had computed another step.
    pub wrong_bits: usize,
    /// Number of steps for which the board's tasks are absent from now on; then they process all that has waited.
    pub away_steps: usize,
    /// The wire is cut, both ways.
    pub cut: bool,
    /// What the PC writes is lost.
    pub is_deaf: bool,
    /// What is received from the board is noise.
    pub is_noisy: bool,
    /// Faults to inject, with their steps, in this order.
    pub incidents: VecDeque<(u64, FaultInjection<A>)>,
}

impl<const A: usize> Loopback<A> {
    /// A board just powered up, with `rig` behind its converters.
    pub fn new(rig: impl Laboratory<A> + 'static) -> Self {
        Self::standing_at(rig, [0.0; A])
    }

    /// The same with a rig left at these positions, m.
    pub fn standing_at(rig: impl Laboratory<A> + 'static, stands_at_m: [f64; A]) -> Self {
        let rig = Box::new(rig);
        let blocked = BlockedRig { rig, stands_at_m };
        let mut board = Bench::new(blocked);
        // The PC's heartbeat comes only from its frames.
        board.alive = [Heartbeat::Listen, Heartbeat::Report, Heartbeat::Report];
        Self {
            board,
            decoder: Decoder::new(),
            commands: VecDeque::new(),
            sequence: 0,
            batch: Telemetry::default(),
            out: VecDeque::new(),
            steps: 0,
            elapsed: Duration::ZERO,
            drop_frames: 0,
            wrong_bits: 0,
            away_steps: 0,
            cut: false,
            is_deaf: false,
            is_noisy: false,
            incidents: VecDeque::new(),
        }
    }

    /// One control step, and the tasks after it.
    fn step(&mut self) {
        self.board.period();
        self.steps += 1;
        let period_ticks = self.board.hardware.board.period_ticks;
        self.elapsed += Duration::from_secs(period_ticks.into()) / CLOCK.stopwatch_hz;
        if self.away_steps > 0 {
            self.away_steps -= 1;
            return;
        }
        while let Some(report) = self.board.take_in() {
            self.report(report);
        }
        self.serve();
        if self
            .incidents
            .front()
            .is_some_and(|(at, _)| self.steps >= *at)
            && let Some((_, mut happen)) = self.incidents.pop_front()
        {
            happen(self);
        }
    }

    fn report(&mut self, mut report: Report) {
        if self.wrong_bits > 0 {
            self.wrong_bits -= 1;
            report.step.digest ^= 1;
        }
        if self.batch.steps.is_empty() {
            self.batch.first_tick = report.tick;
        }
        let _ = self.batch.steps.push(report.step);
        if self.batch.steps.len() == STEPS {
            let batch = std::mem::take(&mut self.batch);
            // The second displacement, and each command read back.
            self.send(FrameKind::Telemetry, &batch.encode(A, 1 + A));
        }
    }

    fn serve(&mut self) {
        let answer = if self.board.is_waiting() {
            self.board.go_on()
        } else {
            let next = self.commands.pop_front();
            let seen = self.decoder.seen();
            next.and_then(|(request, command)| self.board.receive(request, command, seen))
        };
        if let Some(answer) = answer {
            self.answer(&answer);
        }
    }

    fn answer(&mut self, answer: &NumberedReply) {
        let wire = answer.encode(self.sequence).expect("answers fit");
        self.sequence = self.sequence.wrapping_add(1);
        self.out.extend(wire);
    }

    fn send(&mut self, kind: FrameKind, body: &[u8]) {
        let sequence = self.sequence;
        self.sequence = self.sequence.wrapping_add(1);
        if self.drop_frames > 0 {
            self.drop_frames -= 1;
            return;
        }
        let frame = Frame {
            kind,
            sequence,
            body,
        };
        self.out.extend(frame.encode().expect("telemetry fits"));
    }
}

impl<const A: usize> Port for Loopback<A> {
    fn now(&self) -> Duration {
        self.elapsed
    }

    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        for _ in 0..20 {
            self.step();
        }
        if self.cut {
            self.out.clear();
            return Err(io::Error::other("the wire is cut"));
        }
        if self.is_noisy {
            self.out.iter_mut().for_each(|byte| *byte = 0x55);
        }
        let count = bytes.len().min(self.out.len());
        for (place, byte) in bytes.iter_mut().zip(self.out.drain(..count)) {
            *place = byte;
        }
        Ok(count)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        if self.cut {
            return Err(io::Error::other("the wire is cut"));
        }
        if self.is_deaf {
            return Ok(());
        }
        for &byte in bytes {
            let Some(frame) = self.decoder.push(byte) else {
                continue;
            };
            let (request, command) = (frame.sequence, Command::received(&frame));
            self.board.heartbeats.beat(Heartbeat::Pc);
            match command {
                Ok(command) => self.commands.push_back((request, command)),
                Err(why) => self.answer(&NumberedReply {
                    request,
                    reply: why.into(),
                }),
            }
        }
        Ok(())
    }
}
