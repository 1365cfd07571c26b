//! A board without hardware: station and service as on the metal, a spring behind converters of 12 bits.
#![allow(missing_docs)]

use core::cell::Cell;
use firmware::converters::Stopwatch;
use firmware::station::*;
use heapless::spsc::{Consumer, Queue};
use link::channel::Calibration;
use link::command::Command;
use link::frame::{Seen, checksum};
use link::reply::Reply;
use link::status::Start;
use link::{AdcCode, DacCode};
use outerloop_core::Config;
use outerloop_core::{Event, Fault, State};

pub const STIFFNESS_N_PER_M: f64 = 158e3;

pub const CLOCK: Clock = Clock {
    timer_hz: 84_000_000,
    slowest_rate_hz: 100,
    fastest_rate_hz: 3400,
    deadline_ticks: u32::MAX,
    stopwatch_hz: 168_000_000,
};

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

/// A rig with a first-order lag of 4 ms, sampled as the board does.
pub struct Rig {
    pub position_m: f64,
    pub code: u16,
    pub permit: bool,
    pub stop_pressed: bool,
    pub fed: u32,
    pub starving: Option<Sign>,
    /// Codes that stand in for the sensors'.
    pub broken: Option<(u16, u16)>,
}

impl Rig {
    fn sensors(&self) -> (AdcCode, AdcCode) {
        let codes = self.broken.unwrap_or_else(|| {
            let c = Calibration::UNCALIBRATED;
            let code = |quantity: f64, line: link::channel::Line| {
                let exact = quantity / f64::from(line.per_code) + f64::from(line.zero_code);
                exact.round().clamp(0.0, f64::from(AdcCode::MAX)) as u16
            };
            (
                code(self.position_m, c.displacement),
                code(self.position_m * STIFFNESS_N_PER_M, c.force),
            )
        });
        (
            AdcCode::new(codes.0).unwrap(),
            AdcCode::new(codes.1).unwrap(),
        )
    }

    /// Half a millisecond of the actuator; without permission it stands.
    fn move_on(&mut self) {
        let line = Calibration::UNCALIBRATED.command;
        let goal = f64::from((f32::from(self.code) - line.zero_code) * line.per_code);
        if self.permit {
            self.position_m += (goal - self.position_m) * (1.0 - (-0.5_f64 / 4.0).exp());
        }
    }
}

impl Hardware for Rig {
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
    fn feed(&mut self) {
        self.fed += 1;
    }
    fn starving(&mut self, task: Sign, _: u32, _: State) {
        self.starving = Some(task);
    }
}

/// The board and the PC's side of it.
pub struct Bench {
    pub station: Station,
    pub service: Service,
    pub rig: Rig,
    pub evidence: &'static Evidence,
    outcomes: Consumer<'static, Outcome>,
    reports: Consumer<'static, Report>,
    /// Every report since the start.
    pub log: Vec<Report>,
    request: Cell<u16>,
    /// The tasks show signs of life.
    pub listening: bool,
    pub reporting: bool,
    pub heard: bool,
}

pub fn bench() -> Bench {
    fn leak<T>(x: T) -> &'static mut T {
        Box::leak(Box::new(x))
    }
    let (orders_in, orders) = leak(Queue::<Order, 4>::new()).split();
    let (outcomes, outcomes_out) = leak(Queue::<Outcome, 4>::new()).split();
    let (reports, reports_out) = leak(Queue::<Report, 64>::new()).split();
    let evidence = leak(Evidence::new());
    let rig = Rig {
        position_m: 0.003,
        code: 0,
        permit: false,
        stop_pressed: false,
        fed: 0,
        starving: None,
        broken: None,
    };
    let setup = || leak(Setup::unconfigured(&CLOCK).unwrap());
    let first = setup();
    let in_force = (first.rate_hz, first.model_step_s);
    let ends = Ends {
        orders,
        outcomes,
        reports,
    };
    let calibration = Calibration::UNCALIBRATED;
    let codes = rig.sensors();
    Bench {
        station: Station::new(first, calibration, codes, evidence, ends, 2),
        service: Service::new(
            firmware::station::Board {
                name: "host",
                commit: "none",
                clock: CLOCK,
                output_delay_us: 50.0,
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
        rig,
        evidence,
        outcomes: outcomes_out,
        reports: reports_out,
        log: Vec::new(),
        request: Cell::new(0),
        listening: true,
        reporting: true,
        heard: true,
    }
}

impl Bench {
    pub fn step(&mut self) {
        self.rig.move_on();
        self.station.tick(&mut self.rig);
        if self.listening {
            self.evidence.show(Sign::Listen);
        }
        if self.reporting {
            self.evidence.show(Sign::Report);
        }
        if self.heard {
            self.evidence.show(Sign::Heard);
        }
        while let Some(report) = self.reports.dequeue() {
            self.service.see(&report);
            self.log.push(report);
        }
    }

    pub fn ask_again(&mut self, command: Command) -> Reply {
        let mut asked = self
            .service
            .hear(self.request.get(), command, Seen::default(), 0);
        loop {
            asked = match asked {
                Asked::Reply(answer) => {
                    assert_eq!(answer.request, self.request.get());
                    return answer.reply;
                }
                Asked::Save(settings) => {
                    let mut room = [0; SETTINGS_BYTES];
                    let written = settings.encode(&mut room).is_some();
                    return self.service.saved(written).reply;
                }
                Asked::Wait => {
                    self.step();
                    let outcome = self.outcomes.dequeue().expect("an outcome after a step");
                    self.service.finish(outcome)
                }
            }
        }
    }

    pub fn ask(&mut self, command: Command) -> Reply {
        self.request.set(self.request.get().wrapping_add(1));
        self.ask_again(command)
    }

    pub fn event(&mut self, event: Event) -> Reply {
        self.ask(Command::Event(event))
    }

    pub fn state(&self) -> State {
        self.log.last().unwrap().step.state().unwrap()
    }

    /// Steps until the state is `state`; returns how many.
    pub fn until(&mut self, state: State) -> usize {
        for steps in 0..60_000 {
            if !self.log.is_empty() && self.state() == state {
                return steps;
            }
            self.step();
        }
        panic!("still {:?}, not {state:?}", self.state());
    }

    pub fn upload(&mut self, points: &[f32], interval_s: f64) {
        let sum = checksum(points.iter().flat_map(|p| p.to_le_bytes()));
        let begin = Command::Motion {
            points: points.len() as u32,
            interval_s,
            checksum: sum,
        };
        assert!(matches!(self.ask(begin), Reply::Done { .. }));
        for (i, chunk) in points.chunks(link::command::CHUNK).enumerate() {
            let command = Command::Points {
                first: (i * link::command::CHUNK) as u32,
                points: chunk.iter().copied().collect(),
            };
            let reply = self.ask(command);
            assert!(matches!(reply, Reply::Done { .. }), "{reply:?}");
        }
    }

    /// Configured, loaded, armed and at the start.
    pub fn ready(&mut self, config: Config, points: &[f32]) {
        assert!(matches!(
            self.ask(Command::Configure(config)),
            Reply::Done { .. }
        ));
        self.upload(points, 0.01);
        for _ in 0..300 {
            self.step();
        }
        let armed = self.event(Event::Arm);
        assert!(
            matches!(
                armed,
                Reply::Done {
                    state: State::Approaching | State::Armed,
                    ..
                }
            ),
            "{armed:?}"
        );
        for _ in 0..60_000 {
            self.step();
            if self.log.last().unwrap().step.command_m == 0.0 {
                break;
            }
        }
    }

    pub fn fault(&self) -> Option<Fault> {
        self.log.last().unwrap().step.fault()
    }
}

pub fn config() -> Config {
    let mut config = Config::shear_frame([1000.0], [STIFFNESS_N_PER_M], [0.02]);
    config.limits.displacement_m = Some(0.045);
    config.limits.stale_steps = Some(20);
    config
}

/// Two seconds of a pulse, m/s^2, a point every 10 ms.
pub fn pulse() -> Vec<f32> {
    (0..200)
        .map(|i| {
            if i < 50 {
                (i as f32 * 0.1256).sin() * 1.5
            } else {
                0.0
            }
        })
        .collect()
}
