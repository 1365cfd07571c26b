//! The emulated board on the desk and the PC's side of the link, both in this process.

use emu::nucleo::{HEALTHY_MV, Nucleo, RIGHT_CRYSTAL_HZ, USUAL_LSI_HZ};
use emu::{
    Converters, CoreBits, Firmware, Laboratory, Log, LoggedEvent, Mutant, PlannedFault, Wire,
};
use link::command::Command;
use link::frame::checksum;
use link::reply::Reply;
use link::status::Status;
use link::telemetry::StepReport;
use link::{Calibration, CodeRange};
use outerloop_cli::board::in_turns::{InTurns, Turns};
use outerloop_cli::board::{Connection, Image, Timeouts, calibrate, status};
use outerloop_core::{Config, Event, Mode, config::Limits};
use plant::{Rig, RigSpec};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};
use std::thread::JoinHandle;

/// Table 1 of the paper; the actuator is the desk's.
pub const TABLE_1: &str = "
[structure]
mass_kg = 1000
stiffness_n_per_m = 158e3
damping_ratio = 0.02
[plant.actuator]
kind = 'delay'
delay_ms = 3
[plant.specimen]
kind = 'linear'
[excitation]
peak_response_mm = 20
duration_s = 10
";

/// Control period, ns.
pub const PERIOD_NS: u64 = 500_000;

/// Default limit of a scenario's duration, s of the board's time.
const LONGEST_S: u64 = 20;

/// Converters of the image of these tests.
pub const CONVERTERS: Converters = match crate::IMAGE {
    Image::Internal => Converters::Internal,
    Image::External => Converters::External,
    Image::Three => Converters::Three,
};

/// Number of actuators, and of floors, of the image of these tests.
pub const ACTUATORS: usize = match crate::IMAGE {
    Image::Internal | Image::External => 1,
    Image::Three => 3,
};

/// Their codes.
pub fn codes() -> CodeRange {
    crate::IMAGE.codes()
}

/// Command codes in 24 um, the size of a code with 12 bits: the scenarios' bounds are multiples of it.
pub fn fine() -> u16 {
    codes().command_top / 4095
}

/// The flashed image: the one named by the environment, otherwise built when the first test needs it.
pub fn image() -> &'static Path {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let name = crate::IMAGE.name();
    BUILT.get_or_init(|| {
        if let Some(built) = std::env::var_os(crate::IMAGE.variable()) {
            return built.into();
        }
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let target = std::env::var_os("CARGO_TARGET_DIR")
            .map_or_else(|| root.join("target"), |named| root.join(named));
        let built = std::process::Command::new(root.join("scripts/cross"))
            .args(["build", "-p", "firmware", "--bin", name, "--release"])
            .env("CARGO_TARGET_DIR", &target)
            .status()
            .expect("scripts/cross starts");
        assert!(
            built.success(),
            "the image builds; scripts/setup installs what that needs"
        );
        target
            .join("cross/thumbv7em-none-eabihf/release")
            .join(name)
    })
}

/// The PC's end of the serial line.
pub type Line = InTurns<WiredPc>;

/// A PC at a wire in this process.
pub struct WiredPc(Wire);

impl Turns for WiredPc {
    fn exchange(&mut self, bytes: &[u8]) -> io::Result<(u64, Vec<u8>)> {
        let came = self.0.exchange(bytes);
        came.ok_or_else(|| io::Error::other("the emulator has ended"))
    }
}

/// Settings of a board and its laboratory.
pub struct Bench {
    pub firmware: Option<Firmware>,
    pub crystal_hz: u64,
    pub lsi_hz: u64,
    pub supply_mv: u32,
    pub plan: Option<PlannedFault>,
    /// Further faults, each after a reset.
    pub then: Vec<PlannedFault>,
    pub mutant: Option<Mutant>,
    /// The rig; by default 3 ms late, with a linear specimen.
    pub rig: Option<RigSpec>,
    /// How fast the rig sinks without permission to move, m/s.
    pub sinks_m_per_s: f64,
    /// Velocity limit of the actuators by their valves, m/s.
    pub valve_m_per_s: f64,
    /// The actuator with the fault, from 0.
    pub actuator: usize,
    /// When the emulator ends by itself, s of the board's time.
    pub longest_s: u64,
    /// Access to the processor.
    pub processor: Option<CoreBits>,
}

impl Default for Bench {
    fn default() -> Self {
        Self {
            firmware: None,
            crystal_hz: RIGHT_CRYSTAL_HZ,
            lsi_hz: USUAL_LSI_HZ,
            supply_mv: HEALTHY_MV,
            plan: None,
            then: Vec::new(),
            mutant: None,
            rig: None,
            sinks_m_per_s: 0.0,
            valve_m_per_s: f64::INFINITY,
            actuator: 0,
            longest_s: LONGEST_S,
            processor: None,
        }
    }
}

/// A board, its laboratory, and a PC.
pub struct Desk {
    pub pc: Connection<Line>,
    /// Every step of the telemetry since the start of the test.
    pub steps: Vec<(u32, StepReport)>,
    /// The serial line itself.
    pub wire: Wire,
    /// The laboratory's log, see [`Desk::log`].
    pub log: Arc<Mutex<Log>>,
    board: Option<JoinHandle<Result<(), String>>>,
}

/// The course of events after a fault.
#[derive(Debug)]
pub struct Course {
    /// When it came, ns.
    pub fault_ns: u64,
    /// When PERMIT went low after it, ns.
    pub permit_low_ns: u64,
    /// When the chip was reset after it, ns.
    pub reset_ns: Option<u64>,
    /// The code in force when PERMIT went low.
    pub held: u16,
    /// All codes written between then and the reset, if there was one.
    pub written_before_reset: Vec<u16>,
    /// The first code after the reset.
    pub first_after_reset: Option<u16>,
}

impl Desk {
    /// Switches on a board, with a planned fault.
    pub fn new(plan: Option<PlannedFault>) -> Self {
        Self::with(Bench {
            plan,
            ..Bench::default()
        })
    }

    /// Switches on a board with these settings.
    pub fn with(bench: Bench) -> Self {
        let firmware = bench
            .firmware
            .unwrap_or_else(|| Firmware::read(image()).expect("an image"));
        let spec = bench.rig.unwrap_or_else(|| {
            let text = "[actuator]\nkind = 'delay'\ndelay_ms = 3.0\n[specimen]\nkind = 'linear'\n[sensors]\n";
            toml::from_str(text).expect("a rig")
        });
        let rig = Rig::new(&spec, &[STIFFNESS_N_PER_M; ACTUATORS], 2000.0, 1).expect("a rig");
        let wire = Wire::default();
        let drill = firmware.symbol("DRILL").expect("the symbol DRILL");
        let points = firmware.variable("6POINTS").expect("the ground motion");
        let laboratory = Laboratory::new(wire.clone(), rig, drill)
            .with_motion_at(points)
            .with_converters(CONVERTERS)
            .sinking(bench.sinks_m_per_s)
            .with_valves(bench.valve_m_per_s)
            .with_plan(bench.plan.into_iter().chain(bench.then))
            .at_actuator(bench.actuator)
            .mutated(bench.mutant)
            .until_ns(bench.longest_s * 1_000_000_000);
        let log = laboratory.log();
        let theirs = wire.clone();
        let board = std::thread::spawn(move || {
            let run = || {
                let mut board = Nucleo::new(bench.crystal_hz, bench.lsi_hz, theirs.clone())
                    .map_err(|e| e.to_string())?
                    .with_converters(CONVERTERS)
                    .supplied(bench.supply_mv);
                if let Some(processor) = bench.processor {
                    board = board.with_core_bits(processor);
                }
                emu::run(board, &firmware.images, laboratory)
            };
            let ended = run();
            theirs.close();
            ended
        });
        let line = Line::new(WiredPc(wire.clone()));
        Self {
            pc: Connection::new(line, Timeouts::BOARD),
            steps: Vec::new(),
            wire,
            log,
            board: Some(board),
        }
    }

    /// A connection that replaces the one here.
    pub fn connection(&self) -> Connection<Line> {
        Connection::new(Line::new(WiredPc(self.wire.clone())), Timeouts::BOARD)
    }

    /// Asks twice: after another connection, half of its heartbeat may be on the wire, and what follows it is lost with it.
    pub fn status(&mut self) -> Status {
        status(&mut self.pc)
            .or_else(|_| status(&mut self.pc))
            .expect("a status")
    }

    pub fn ask(&mut self, command: Command) -> Reply {
        self.pc.ask(&command).expect("an answer")
    }

    /// Sends a command that must be accepted.
    pub fn order(&mut self, command: Command) {
        let reply = self.ask(command);
        assert!(matches!(reply, Reply::Done { .. }), "{reply:?}");
    }

    /// A board with a running test, and access to its processor.
    pub fn running_looked_into() -> (Self, CoreBits) {
        let processor = CoreBits::default();
        let mut desk = Self::with(Bench {
            processor: Some(processor.clone()),
            ..Bench::default()
        });
        desk.start();
        desk.until(Mode::Running);
        (desk, processor)
    }

    /// A step of the telemetry.
    pub fn step(&mut self) -> StepReport {
        loop {
            if let Some((tick, step)) = self.pc.step().expect("the link") {
                self.steps.push((tick, step));
                return step;
            }
        }
    }

    /// Advances the board's time by a turn, even if the board is silent: the timeout of the link does not matter here.
    pub fn turn(&mut self) {
        if let Ok(Some(step)) = self.pc.step() {
            self.steps.push(step);
        }
    }

    /// Calibrates the board, configures and loads a test, and lets it idle for a while.
    pub fn load(&mut self) {
        self.calibrate();
        self.order(Command::Configure(config().into()));
        let points = pulse();
        self.order(Command::Motion {
            points: points.len() as u32,
            interval_s: 0.01,
            checksum: checksum(points.iter().flat_map(|p| p.to_le_bytes())),
        });
        for (first, chunk) in (0..)
            .step_by(link::command::CHUNK)
            .zip(points.chunks(link::command::CHUNK))
        {
            self.order(Command::Points {
                first,
                points: chunk.iter().copied().collect(),
            });
        }
        self.pc.forget_steps();
        for _ in 0..300 {
            self.step();
        }
    }

    /// Calibrates the board as it is wired.
    pub fn calibrate(&mut self) {
        calibrate(&mut self.pc, Calibration::nominal(&codes())).expect("a calibration");
    }

    /// Loads and starts a test.
    pub fn start(&mut self) {
        self.load();
        self.arm_and_start();
    }

    /// Starts what is loaded, once the rig stands at zero.
    pub fn arm_and_start(&mut self) {
        self.order(Command::Event(Event::Arm));
        while self.step().mode() != Some(Mode::Armed) {}
        while self.step().command_m != 0.0 {}
        self.order(Command::Event(Event::Start));
    }

    /// Steps until the board has been reset: its steps count from zero again.
    pub fn until_reset(&mut self) {
        let mut before = self.steps.last().map_or(0, |s| s.0);
        loop {
            self.step();
            let tick = self.steps.last().map_or(0, |s| s.0);
            if tick < before {
                return;
            }
            before = tick;
        }
    }

    /// Steps until the mode is `mode`.
    pub fn until(&mut self, mode: Mode) {
        while self.step().mode() != Some(mode) {}
    }

    /// No step is missing between the first and the last; after a reset they count from zero again.
    pub fn assert_nothing_lost(&self) {
        let ticks: Vec<u32> = self.steps.iter().map(|s| s.0).collect();
        let gaps = ticks
            .windows(2)
            .filter(|w| w[1] > w[0] && w[1] != w[0] + 1)
            .count();
        assert_eq!(gaps, 0, "steps are missing");
    }

    /// The laboratory's log.
    pub fn log(&self) -> Log {
        self.log
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .clone()
    }

    /// The course of the planned fault.
    pub fn course(&self) -> Course {
        let seen = self.log().seen;
        let at = seen
            .iter()
            .position(|(_, s)| *s == LoggedEvent::Fault)
            .expect("the fault came");
        let fault_ns = seen[at].0;
        let low = at
            + seen[at..]
                .iter()
                .position(|(_, s)| *s == LoggedEvent::Permit(false))
                .expect("PERMIT goes low");
        let code = |s: &(u64, LoggedEvent)| match s.1 {
            LoggedEvent::Command(code) => Some(code),
            _ => None,
        };
        let reset = seen[at..]
            .iter()
            .position(|(_, s)| *s == LoggedEvent::Reset)
            .map(|i| at + i);
        let end = reset.unwrap_or(seen.len()).max(low);
        Course {
            fault_ns,
            permit_low_ns: seen[low].0,
            reset_ns: reset.map(|i| seen[i].0),
            held: seen[..low].iter().rev().find_map(code).expect("a command"),
            written_before_reset: seen[low..end].iter().filter_map(code).collect(),
            first_after_reset: reset.and_then(|i| seen[i..].iter().find_map(code)),
        }
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.wire.close();
        if let Some(Ok(Err(sentence))) = self.board.take().map(JoinHandle::join) {
            eprintln!("the emulator ended: {sentence}");
        }
    }
}

/// Stiffness of a storey, for a fundamental period of half a second.
pub const STIFFNESS_N_PER_M: f64 = match crate::IMAGE {
    Image::Internal | Image::External => 158e3,
    Image::Three => 797.3e3,
};

/// Table 1 of the paper with limits.
pub fn config() -> Config {
    let each = |x| [x; ACTUATORS];
    let mut config = Config::shear_frame(each(1000.0), each(STIFFNESS_N_PER_M), each(0.02));
    if ACTUATORS > 1 {
        // As in `examples/three-storey.toml`.
        (config.compensation.gamma, config.compensation.clamp) = (0.02, 4.0);
    }
    config.limits = Limits {
        displacement_m: Some(0.042),
        velocity_m_per_s: Some(1.0),
        force_n: Some(8000.0),
        tracking_m: Some(0.01),
        energy_trip: Some(3.0),
        stale_steps: Some(20),
        ..Limits::default()
    };
    config
}

/// A half sine of 1.5 m/s^2 and rest, a point every 10 ms.
fn pulse() -> Vec<f32> {
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
