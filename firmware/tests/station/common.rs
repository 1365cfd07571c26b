//! The simulated board with a spring behind it, and a PC that asks.

use firmware::sim::{self, CODES, Plant};
use firmware::station::{Board, Report};
use link::Calibration;
use link::command::Command;
use link::frame::{DecoderCounts, checksum};
use link::reply::Reply;
use outerloop_core::{Config, Event, Fault, Mode, OBSTACLE_STEPS, config::Limits};
use std::ops::{Deref, DerefMut};

pub const STIFFNESS_N_PER_M: f64 = 158e3;

/// A spring on an actuator with a first-order lag of 4 ms; without permission it stands.
pub struct Spring {
    pub position_m: f64,
}

impl Plant for Spring {
    fn step(&mut self, [command_m]: [f64; 1], permit: bool) -> [[f64; 2]; 1] {
        if permit {
            self.position_m += (command_m - self.position_m) * (1.0 - (-0.5_f64 / 4.0).exp());
        }
        [[self.position_m, self.position_m * STIFFNESS_N_PER_M]]
    }
}

/// The board and the PC's side of it.
pub struct Bench {
    pub board: sim::Bench<Spring>,
    /// Every report since the start.
    pub log: Vec<Report>,
    request: u16,
}

impl Deref for Bench {
    type Target = sim::Bench<Spring>;
    fn deref(&self) -> &Self::Target {
        &self.board
    }
}

impl DerefMut for Bench {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.board
    }
}

/// Power on, and nobody has calibrated it.
pub fn fresh() -> Bench {
    started(sim::Bench::<Spring>::well("sim"))
}

/// As [`fresh`], with what the board has found at its start.
pub fn started(found: Board) -> Bench {
    let hardware = sim::Faulty::new(sim::SimBoard::new(Spring { position_m: 0.003 }));
    Bench {
        board: sim::Bench::started(hardware, found, Calibration::placeholder(&CODES)),
        log: Vec::new(),
        request: 0,
    }
}

/// Calibrated as it is wired.
pub fn bench() -> Bench {
    let mut bench = fresh();
    let calibrated = bench.ask(Command::Calibrate(0, Calibration::nominal(&CODES)));
    assert!(matches!(calibrated, Reply::Done { .. }), "{calibrated:?}");
    bench
}

impl Bench {
    pub fn step(&mut self) {
        let report = self.board.step();
        self.log.push(report);
    }

    /// Control periods in which the tasks do nothing, and then all that has waited.
    pub fn step_without_tasks(&mut self, steps: usize) {
        (0..steps).for_each(|_| self.board.period());
        while let Some(report) = self.board.take_in() {
            self.log.push(report);
        }
    }

    pub fn ask_again(&mut self, command: Command) -> Reply {
        let mut answer = self
            .board
            .receive(self.request, command, DecoderCounts::default());
        loop {
            if let Some(answer) = answer {
                assert_eq!(answer.request, self.request);
                return answer.reply;
            }
            self.step();
            answer = self.board.go_on();
        }
    }

    pub fn ask(&mut self, command: Command) -> Reply {
        self.request = self.request.wrapping_add(1);
        self.ask_again(command)
    }

    pub fn event(&mut self, event: Event) -> Reply {
        self.ask(Command::Event(event))
    }

    pub fn permit(&self) -> bool {
        self.board.hardware.board.permit
    }

    pub fn code(&self) -> u16 {
        self.board.hardware.board.code[0]
    }

    pub fn mode(&self) -> Mode {
        self.log.last().unwrap().step.mode().unwrap()
    }

    /// Steps until the mode is `mode`; returns how many.
    pub fn until(&mut self, mode: Mode) -> usize {
        for steps in 0..60_000 {
            if !self.log.is_empty() && self.mode() == mode {
                return steps;
            }
            self.step();
        }
        panic!("still {:?}, not {mode:?}", self.mode());
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

    /// Whatever stood against arming has been gone for long enough.
    pub fn settle(&mut self) {
        for _ in 0..=OBSTACLE_STEPS {
            self.step();
        }
    }

    /// Configured, loaded, armed and at the start.
    pub fn ready(&mut self, config: Config, points: &[f32]) {
        let configured = self.ask(Command::Configure(config.into()));
        assert!(matches!(configured, Reply::Done { .. }), "{configured:?}");
        self.upload(points, 0.01);
        self.settle();
        let armed = self.event(Event::Arm);
        assert!(
            matches!(
                armed,
                Reply::Done {
                    mode: Mode::Approaching | Mode::Armed,
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
    config.limits = Limits {
        energy_trip: Some(3.0),
        displacement_m: Some(0.042),
        velocity_m_per_s: Some(1.0),
        force_n: Some(8000.0),
        tracking_m: Some(0.02),
        stale_steps: Some(20),
        ..Limits::default()
    };
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
