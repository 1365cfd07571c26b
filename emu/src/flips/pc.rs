//! A PC that runs on the board's time: it calibrates, configures, loads, arms and starts, and asks for the status. What it
//! sends, and when, is the same in every run.

use crate::chain::Converters;
use crate::wire::Wire;
use link::frame::{Decoder, FrameKind, checksum};
use link::message::Message;
use link::reply::{NumberedReply, Reply};
use link::{Calibration, Command, Telemetry};
use outerloop_core::{Config, Event, Mode, config::Limits};
use std::collections::VecDeque;

/// Stiffness of the specimen, N/m: with 1000 kg a period of half a second.
pub(super) const STIFFNESS_N_PER_M: f64 = 158e3;

/// Interval between two requests for the status, ns.
const STATUS_NS: u64 = 50_000_000;

/// Time without an answer after which a command is sent again, ns.
const TIMEOUT_NS: u64 = 100_000_000;

/// The test: Table 1 of the paper with the limits that a board requires.
fn config() -> Config {
    let mut config = Config::shear_frame([1000.0], [STIFFNESS_N_PER_M], [0.02]);
    config.limits = Limits {
        displacement_m: Some(0.042),
        velocity_m_per_s: Some(1.0),
        force_n: Some(8000.0),
        tracking_m: Some(1.5e-3),
        disagree_m: Some(1e-3),
        force_stands_m: Some(2e-3),
        energy_trip: Some(3.0),
        stale_steps: Some(20),
        ..Limits::default()
    };
    config
}

/// A half sine of 1.5 m/s^2 and rest, a point every 10 ms.
fn pulse() -> Vec<f32> {
    let risen = (0..50).map(|i| (i as f32 * 0.1256).sin() * 1.5);
    risen.chain([0.0; 150]).collect()
}

/// What the PC sends before it only asks for the status.
fn commands(converters: Converters) -> VecDeque<Command> {
    let points = pulse();
    let mut all = VecDeque::from([
        Command::Calibrate(0, Calibration::over(0.05, 1e4, &converters.widths())),
        Command::Configure(config().into()),
        Command::Motion {
            points: points.len() as u32,
            interval_s: 0.01,
            checksum: checksum(points.iter().flat_map(|p| p.to_le_bytes())),
        },
    ]);
    let chunks = points.chunks(link::command::CHUNK).enumerate();
    all.extend(chunks.map(|(number, chunk)| Command::Points {
        first: (number * link::command::CHUNK) as u32,
        points: chunk.iter().copied().collect(),
    }));
    all.extend([Command::Event(Event::Arm), Command::Event(Event::Start)]);
    all
}

/// The PC.
#[derive(Debug)]
pub(super) struct Pc {
    wire: Wire,
    decoder: Decoder,
    commands: VecDeque<Command>,
    /// The number of the command that has no answer yet, and when it was sent, ns.
    asked: Option<(u16, u64)>,
    sequence: u16,
    spoke_ns: u64,
    /// Mode in the last step received.
    mode: Option<Mode>,
    /// When the board answered the start of the test, ns.
    pub(super) started_ns: Option<u64>,
    /// What the board refused.
    pub(super) refused: Option<String>,
    /// Every byte received.
    pub(super) heard: Vec<u8>,
}

impl Pc {
    pub(super) fn new(wire: Wire, converters: Converters) -> Self {
        Self {
            wire,
            decoder: Decoder::new(),
            commands: commands(converters),
            asked: None,
            sequence: 0,
            spoke_ns: 0,
            mode: None,
            started_ns: None,
            refused: None,
            heard: Vec::new(),
        }
    }

    /// Its turn: reads what has been received, and sends what is due.
    pub(super) fn turn(&mut self, at_ns: u64) {
        for byte in self.wire.take() {
            self.heard.push(byte);
            self.hear(byte, at_ns);
        }
        let waits = self.commands.front() == Some(&Command::Event(Event::Start))
            && self.mode != Some(Mode::Armed);
        match self.asked {
            Some((_, sent_ns)) if at_ns - sent_ns < TIMEOUT_NS => {}
            None if waits || self.commands.is_empty() => {
                if at_ns - self.spoke_ns >= STATUS_NS {
                    self.sequence = self.sequence.wrapping_add(1);
                    self.say(&Command::Status, self.sequence, at_ns);
                }
            }
            again => {
                let number = again.map_or(self.sequence.wrapping_add(1), |(number, _)| number);
                if let Some(command) = self.commands.front().cloned() {
                    (self.sequence, self.asked) = (number, Some((number, at_ns)));
                    self.say(&command, number, at_ns);
                }
            }
        }
    }

    fn say(&mut self, command: &Command, number: u16, at_ns: u64) {
        self.spoke_ns = at_ns;
        // No command of this list is too long for a frame.
        if let Ok(frame) = command.encode(number) {
            self.wire.send(&[0]);
            self.wire.send(&frame);
        }
    }

    fn hear(&mut self, byte: u8, at_ns: u64) {
        let Some(frame) = self.decoder.push(byte) else {
            return;
        };
        if frame.kind == FrameKind::Telemetry {
            let steps = Telemetry::decode(frame.body);
            let last = steps.and_then(|steps| steps.steps.last().copied());
            self.mode = last.and_then(|step| step.mode()).or(self.mode);
            return;
        }
        let Some(answer) = NumberedReply::decode(&frame) else {
            return;
        };
        if self.asked.map(|(number, _)| number) != Some(answer.request) {
            return;
        }
        self.asked = None;
        let command = self.commands.pop_front();
        if !matches!(answer.reply, Reply::Done { .. }) {
            self.refused = Some(format!("{command:?}: {:?}", answer.reply));
        }
        if command == Some(Command::Event(Event::Start)) {
            self.started_ns = Some(at_ns);
        }
    }
}
