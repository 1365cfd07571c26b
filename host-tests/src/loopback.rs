//! The firmware's station and service behind frames of bytes, with a simulated rig behind converters of 12 bits: what a
//! PC sees of a board, in this process and in one thread. A read runs the board on by some steps.

use firmware::converters::Stopwatch;
use firmware::station::{
    Asked, Board, Clock, Ends, Evidence, Hardware, Order, Outcome, Parts, Points, Report,
    SETTINGS_BYTES, Service, Setup, Sign, Station,
};
use heapless::spsc::{Consumer, Queue};
use link::channel::{Calibration, Line};
use link::frame::{Decoder, Frame, Kind};
use link::message::Message;
use link::reply::Answer;
use link::status::Start;
use link::telemetry::STEPS;
use link::{AdcCode, Command, DacCode, Telemetry};
use outerloop_cli::board::Port;
use outerloop_core::State;
use plant::Rig;
use std::collections::VecDeque;
use std::io;

const CLOCK: Clock = Clock {
    timer_hz: 84_000_000,
    slowest_rate_hz: 100,
    fastest_rate_hz: 3400,
    deadline_ticks: u32::MAX,
    stopwatch_hz: 168_000_000,
};

/// A clock that stands: no step takes any time.
#[derive(Clone, Copy)]
pub struct Still;

impl Stopwatch for Still {
    fn between(earlier: u32, later: u32) -> u32 {
        later.wrapping_sub(earlier)
    }
    fn now(&self) -> u32 {
        0
    }
}

/// The converters, and the rig behind them.
pub struct Laboratory {
    rig: Rig,
    /// Code of the output converter.
    pub code: u16,
    /// The PERMIT line.
    pub permit: bool,
    /// The emergency stop's contact is open.
    pub stop_pressed: bool,
    /// A sensor's wire is broken: its code is the rail's.
    pub broken_wire: bool,
}

impl Laboratory {
    fn sensors(&mut self) -> (AdcCode, AdcCode) {
        let c = Calibration::UNCALIBRATED;
        let goal = f64::from((f32::from(self.code) - c.command.zero_code) * c.command.per_code);
        let reading = self.rig.step(&[goal]);
        let code = |quantity: f64, line: Line| {
            let one = (quantity / f64::from(line.per_code) + f64::from(line.zero_code)) / 2.0;
            let one = one.round().clamp(0.0, 4095.0) as u16;
            AdcCode::from_pair(one, one).expect("12 bits each")
        };
        if self.broken_wire {
            return (code(1.0, c.displacement), code(0.0, c.force));
        }
        (
            code(reading.displacement_m[0], c.displacement),
            code(reading.force_n[0], c.force),
        )
    }
}

impl Hardware for Laboratory {
    type Watch = Still;
    fn watch(&self) -> Still {
        Still
    }
    fn codes(&mut self) -> Option<(AdcCode, AdcCode)> {
        Some(self.sensors())
    }
    fn output(&mut self, code: DacCode) {
        self.code = code.value();
    }
    fn permit(&mut self, on: bool) {
        self.permit = on;
    }
    fn emergency_stop(&self) -> bool {
        self.stop_pressed
    }
    fn set_period(&mut self, _: u32) {}
    fn feed(&mut self) {}
    fn starving(&mut self, _: Sign, _: u32, _: State) {}
}

/// What happens to a loopback after some steps of it.
pub type Mishap = Box<dyn FnMut(&mut Loopback)>;

/// A board at the other end of a port.
pub struct Loopback {
    station: Station,
    service: Service,
    /// The rig and its converters.
    pub laboratory: Laboratory,
    evidence: &'static Evidence,
    outcomes: Consumer<'static, Outcome>,
    reports: Consumer<'static, Report>,
    decoder: Decoder,
    commands: VecDeque<(u16, Command)>,
    waiting: bool,
    sequence: u16,
    batch: Telemetry,
    out: VecDeque<u8>,
    /// Control steps since power-up.
    pub steps: u64,
    /// Frames of telemetry that are dropped on the line from now on.
    pub drop_frames: usize,
    /// The wire is cut: nothing comes and nothing goes.
    pub cut: bool,
    /// What happens, and at which step.
    pub mishap: Option<(u64, Mishap)>,
}

impl Loopback {
    /// A board that has just got power, with `rig` behind its converters.
    pub fn new(rig: Rig) -> Self {
        fn leak<T>(x: T) -> &'static mut T {
            Box::leak(Box::new(x))
        }
        let (orders_in, orders) = leak(Queue::<Order, 4>::new()).split();
        let (outcomes_in, outcomes) = leak(Queue::<Outcome, 4>::new()).split();
        let (reports_in, reports) = leak(Queue::<Report, 128>::new()).split();
        let evidence = leak(Evidence::new());
        let mut laboratory = Laboratory {
            rig,
            code: DacCode::MAX / 2,
            permit: false,
            stop_pressed: false,
            broken_wire: false,
        };
        let setup = || leak(Setup::unconfigured(&CLOCK).expect("2 kHz divides the clock"));
        let first = setup();
        let in_force = (first.rate_hz, first.model_step_s);
        let calibration = Calibration::UNCALIBRATED;
        let ends = Ends {
            orders,
            outcomes: outcomes_in,
            reports: reports_in,
        };
        let codes = laboratory.sensors();
        Self {
            station: Station::new(first, calibration, codes, evidence, ends, 2),
            service: Service::new(
                Board {
                    name: "host",
                    commit: "none",
                    clock: CLOCK,
                    output_delay_us: 40.0,
                    crystal_ok: true,
                    started: Start::Power,
                    last_words: None,
                },
                Parts {
                    orders: orders_in,
                    spare: setup(),
                    writable: leak(Points::new()).claim(),
                    config: None,
                    calibration,
                },
                in_force,
            ),
            laboratory,
            evidence,
            outcomes,
            reports,
            decoder: Decoder::new(),
            commands: VecDeque::new(),
            waiting: false,
            sequence: 0,
            batch: Telemetry::default(),
            out: VecDeque::new(),
            steps: 0,
            drop_frames: 0,
            cut: false,
            mishap: None,
        }
    }

    /// One control step, and what the tasks do after it.
    fn step(&mut self) {
        self.station.tick(&mut self.laboratory);
        self.steps += 1;
        self.evidence.show(Sign::Listen);
        self.evidence.show(Sign::Report);
        while let Some(report) = self.reports.dequeue() {
            self.service.see(&report);
            if self.batch.steps.is_empty() {
                self.batch.first_tick = report.tick;
            }
            let _ = self.batch.steps.push(report.step);
            if self.batch.steps.len() == STEPS {
                let batch = std::mem::take(&mut self.batch);
                self.send(Kind::Telemetry, &batch.encode());
            }
        }
        self.serve();
        if self
            .mishap
            .as_ref()
            .is_some_and(|(at, _)| self.steps >= *at)
            && let Some((_, mut happen)) = self.mishap.take()
        {
            happen(self);
        }
    }

    fn serve(&mut self) {
        let mut asked = if self.waiting {
            let Some(outcome) = self.outcomes.dequeue() else {
                return;
            };
            self.service.finish(outcome)
        } else {
            let Some((request, command)) = self.commands.pop_front() else {
                return;
            };
            self.service.hear(request, command, self.decoder.seen(), 0)
        };
        loop {
            self.waiting = false;
            asked = match asked {
                Asked::Reply(answer) => {
                    self.answer(&answer);
                    return;
                }
                Asked::Save(settings) => {
                    let written = settings.encode(&mut [0; SETTINGS_BYTES]).is_some();
                    Asked::Reply(self.service.saved(written))
                }
                Asked::Wait => {
                    self.waiting = true;
                    return;
                }
            };
        }
    }

    fn answer(&mut self, answer: &Answer) {
        let wire = answer.encode(self.sequence).expect("answers fit");
        self.sequence = self.sequence.wrapping_add(1);
        self.out.extend(wire);
    }

    fn send(&mut self, kind: Kind, body: &[u8]) {
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

impl Port for Loopback {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        for _ in 0..20 {
            self.step();
        }
        if self.cut {
            self.out.clear();
            return Err(io::Error::other("the wire is cut"));
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
        for &byte in bytes {
            let Some(frame) = self.decoder.push(byte) else {
                continue;
            };
            let (request, command) = (frame.sequence, Command::decode(&frame));
            self.evidence.show(Sign::Heard);
            match command {
                Some(command) => self.commands.push_back((request, command)),
                None => {
                    let answer = self.service.not_understood(request);
                    self.answer(&answer);
                }
            }
        }
        Ok(())
    }
}
