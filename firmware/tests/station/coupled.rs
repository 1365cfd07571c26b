//! Two actuators on one coupler, on a board with three: what such a test asks of the station, and what it leaves alone.

use super::common::pulse;
use super::done;
use firmware::sim::{self, CODES, Plant};
use link::Calibration;
use link::command::{BoardTest, Command, CommissioningSignal, SignalShape};
use link::frame::checksum;
use link::reply::{NotReady, Obstacle, Reply};
use outerloop_core::config::Limits;
use outerloop_core::coupled::{
    Bounds, CoupledSettings, Coupler, EstimatorSettings, INTERFACE_AXIS, Plant as Actuators,
    Spreads, SteadyObserver, TrackerSettings, VibrationMode,
};
use outerloop_core::{Config, Event, Fault, Method, Mode, Pace, Structure};

const ARM_M: f64 = 0.125;
const STIFFNESS: [[f64; 2]; 2] = [[104e3, 30e3], [30e3, 96e3]];

/// Actuators that are where they are sent once PERMIT is given, on a coupler with a spring; behind the third output is a wire.
#[derive(Default)]
struct Corner {
    stroke_m: [f64; 2],
    /// What the first load cell is off by, N.
    off_n: f64,
}

impl Plant<3> for Corner {
    fn step(&mut self, command_m: [f64; 3], permit: bool) -> [[f64; 2]; 3] {
        if permit {
            self.stroke_m = [command_m[0], command_m[1]];
        }
        let [a, b] = self.stroke_m;
        let (x, turn) = (0.5 * (a + b), (a - b) / (2.0 * ARM_M));
        let [n, moment] = STIFFNESS.map(|row| row[0] * x + row[1] * turn);
        let [first, second] = [0.5 * (n + moment / ARM_M), 0.5 * (n - moment / ARM_M)];
        [[a, first + self.off_n], [b, second], [0.0, 0.0]]
    }
}

struct Bench {
    board: sim::Bench<Corner, 3>,
    request: u16,
}

impl Bench {
    fn ask(&mut self, command: Command) -> Reply {
        self.request += 1;
        self.board.ask(self.request, command)
    }

    /// A board whose first two actuators somebody has calibrated.
    fn new() -> Self {
        let corner = Corner {
            stroke_m: [5e-5, 2e-5],
            off_n: 0.0,
        };
        let mut bench = Self {
            board: sim::Bench::new(corner),
            request: 0,
        };
        for actuator in 0..2 {
            done(&bench.ask(Command::Calibrate(actuator, Calibration::nominal(&CODES))));
        }
        bench
    }

    fn upload(&mut self, points: &[f32]) {
        done(&self.ask(Command::Motion {
            points: points.len() as u32,
            interval_s: 0.01,
            checksum: checksum(points.iter().flat_map(|p| p.to_le_bytes())),
        }));
        for (first, chunk) in (0..).step_by(128).zip(points.chunks(128)) {
            done(&self.ask(Command::Points {
                first,
                points: chunk.iter().copied().collect(),
            }));
        }
    }

    fn until(&mut self, mode: Mode) {
        for _ in 0..60_000 {
            if self.board.mode() == mode {
                return;
            }
            self.board.step();
        }
        panic!("still {:?}, not {mode:?}", self.board.mode());
    }

    /// Running a ground motion.
    fn started(test: BoardTest) -> Self {
        let mut bench = Self::armed(test, 0.0);
        done(&bench.ask(Command::Event(Event::Start)));
        bench
    }

    /// Armed, the first load cell off by `off_n`.
    fn armed(test: BoardTest, off_n: f64) -> Self {
        let mut bench = Self::new();
        bench.board.hardware.board.plant.off_n = off_n;
        done(&bench.ask(Command::Configure(test)));
        bench.upload(&pulse());
        for _ in 0..300 {
            bench.board.step();
        }
        done(&bench.ask(Command::Event(Event::Arm)));
        bench.until(Mode::Armed);
        bench
    }
}

/// The strokes of the target are sent as they are: for actuators that follow.
fn test() -> BoardTest {
    let mut config = Config::shear_frame([1.0; 2], [1.0; 2], [0.0; 2]);
    config.compensation.kind = Method::None;
    config.timing.rate_hz = 1000.0;
    (config.timing.substeps, config.timing.time_scale) = (1, 1.0);
    config.timing.approach_m_per_s = 0.01;
    config.limits = Limits {
        displacement_m: Some(0.03),
        velocity_m_per_s: Some(1.0),
        force_n: Some(8e3),
        tracking_m: Some(0.01),
        stale_steps: Some(20),
        frozen_m: Some(2e-4),
        energy_trip: Some(3.0),
        ..Limits::default()
    };
    let mode = VibrationMode {
        omega_rad_per_s: 14.0,
        damping_ratio: 0.04,
        participation: -1.0,
    };
    let observer = SteadyObserver {
        modes: [(mode, [0.1, 1.0])].into_iter().collect(),
    };
    let bounds = Bounds {
        position: 0.4,
        speed_per_s: 2.0,
        force: 1e4,
        tracking: 0.1,
    };
    let coupled = CoupledSettings {
        structure: Structure {
            mass: [[1000.0, 0.0], [0.0, 60.0]],
            damping: STIFFNESS.map(|row| row.map(|k| 0.004 * k)),
            stiffness: STIFFNESS.map(|row| row.map(|k| 2.0 * k)),
            numerical_stiffness: STIFFNESS,
            influence: [1.0, 0.0],
            physical: 2,
            physical_mass_kg: [0.0; 2],
        },
        tracker: TrackerSettings {
            coupler: Coupler {
                pin_x_m: [0.0; 2],
                pin_y_m: [-ARM_M as f32, ARM_M as f32],
            },
            estimate: EstimatorSettings {
                plant: Actuators {
                    gain: [[1.0, 0.0], [0.0, 1.0]],
                    slow_pole_rad_per_s: [2e4; 2],
                    fast_pole_rad_per_s: [2e4; 2],
                    lead_s: [[0.0; 2]; 2],
                    path_lead_s: [[0.0; 2]; 2],
                    natural_rad_per_s: 2e4,
                    damping_ratio: 0.7,
                    delay_s: [0.0; 2],
                },
                spreads: Spreads::new(),
                noise_m: 1e-5,
                period_s: 1e-3,
            },
            inverse: false,
            target: [observer.clone(), observer],
            ahead_s: 0.0,
            trust_reading_hz: 50.0,
        },
        interface: [bounds; 2],
    };
    BoardTest {
        config,
        coupled: Some(coupled),
    }
}

fn changed(change: impl FnOnce(&mut CoupledSettings<2>)) -> BoardTest {
    let mut test = test();
    change(test.coupled.as_mut().unwrap());
    test
}

fn refused(reply: Reply) -> (String, String) {
    match reply {
        Reply::Refused(refused) => (refused.name.as_str().into(), refused.to_string()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_test_runs_with_two_of_three_calibrated_and_the_third_output_stands() {
    let mut bench = Bench::started(test());
    let stood = bench.board.hardware.board.code[2];
    let mut turned = 0.0_f64;
    while bench.board.mode() == Mode::Running {
        bench.board.step();
        let [a, b] = bench.board.hardware.board.plant.stroke_m;
        turned = turned.max((a - b).abs());
        assert_eq!(bench.board.hardware.board.code[2], stood);
    }
    assert_eq!(bench.board.mode(), Mode::Finished);
    assert!(turned > 1e-4, "{turned} m: the coupler has not turned");
}

#[test]
fn a_force_of_one_actuator_and_one_about_the_coupler_trip_and_permission_falls() {
    let mut of_actuator = test();
    of_actuator.config.limits.force_n = Some(300.0);
    let of_rotation = changed(|c| c.interface[1].force = 60.0);
    for (test, axes) in [
        (of_actuator, 0..2),
        (of_rotation, INTERFACE_AXIS + 1..INTERFACE_AXIS + 2),
    ] {
        let mut bench = Bench::started(test);
        bench.until(Mode::Tripped);
        let Reply::Status(status) = bench.ask(Command::Status) else {
            panic!("no status");
        };
        let trip = status.trip.expect("a trip");
        assert!(
            trip.fault == Fault::Force && axes.contains(&trip.axis),
            "{trip:?}"
        );
        assert!(!status.permit && !bench.board.hardware.board.permit);
    }
}

#[test]
fn x_and_rotation_come_to_stand_where_the_pc_sends_them() {
    let mut bench = Bench::new();
    done(&bench.ask(Command::Configure(test())));
    done(&bench.ask(Command::Pace(Some(Pace::StopAndGo))));
    let target = |all: &[f32]| Command::Target(all.iter().copied().collect());
    let (name, said) = refused(bench.ask(target(&[1e-3, 1e-3, 0.0])));
    assert!(
        name == "targets" && said.contains("x and the rotation"),
        "{said}"
    );
    for _ in 0..300 {
        bench.board.step();
    }
    done(&bench.ask(Command::Event(Event::Arm)));
    bench.until(Mode::Armed);
    done(&bench.ask(target(&[4e-3, -6e-3])));
    done(&bench.ask(Command::Event(Event::Start)));
    for to in [[4e-3, -6e-3], [-2e-3, 9e-3]] {
        done(&bench.ask(target(&to.map(|x| x as f32))));
        for _ in 0..3000 {
            bench.board.step();
        }
        assert_eq!(bench.board.mode(), Mode::Running);
        let [a, b] = bench.board.hardware.board.plant.stroke_m;
        let at = [0.5 * (a + b), (a - b) / (2.0 * ARM_M)];
        // A code of the command is 12 um.
        assert!((at[0] - to[0]).abs() < 2e-5, "{at:?} for {to:?}");
        assert!((at[1] - to[1]).abs() < 2e-4, "{at:?} for {to:?}");
    }
}

#[test]
fn what_such_a_test_does_not_have_is_refused_in_a_sentence() {
    let mut bench = Bench::new();
    done(&bench.ask(Command::Configure(test())));
    let signal = CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Constant,
        amplitude_m: 0.001,
        seconds: 5.0,
    };
    let pace = Command::Pace(Some(Pace::Continuous));
    for (command, what) in [
        (Command::Signal(Some(signal)), "signal"),
        (pace, "targets without a stop"),
    ] {
        let (name, said) = refused(bench.ask(command));
        assert_eq!(name, what);
        assert!(said.contains("runs on a ground motion, or from"), "{said}");
    }
    for (test, name) in [
        (
            changed(|c| c.structure.mass[0][0] = f64::NAN),
            "coupled.structure",
        ),
        (
            changed(|c| c.structure.damping[1][0] = f64::INFINITY),
            "coupled.structure",
        ),
        (
            changed(|c| c.tracker.target[0].modes.clear()),
            "observer.modes",
        ),
        (
            changed(|c| c.tracker.target[1].modes[0].1[1] = f64::NAN),
            "observer.gain",
        ),
        (
            changed(|c| c.tracker.target[1].modes[0].0.participation = f64::NAN),
            "observer.participation",
        ),
        (
            changed(|c| c.tracker.estimate.plant.gain = [[1.0; 2]; 2]),
            "plant.gain",
        ),
        (
            changed(|c| c.interface[1].position = 0.6),
            "coupled.limits.rotation_rad",
        ),
    ] {
        assert_eq!(refused(bench.ask(Command::Configure(test))).0, name);
    }
    // A board with one actuator has no such rig.
    let mut one = super::bench();
    let (name, said) = refused(one.ask(Command::Configure(test())));
    assert_eq!(name, "coupled");
    assert!(said.ends_with("or the image for three actuators"), "{said}");
}

#[test]
fn arming_asks_for_the_calibrations_of_the_two_and_no_more() {
    let corner = Corner::default();
    let mut bench = Bench {
        board: sim::Bench::new(corner),
        request: 0,
    };
    done(&bench.ask(Command::Calibrate(0, Calibration::nominal(&CODES))));
    done(&bench.ask(Command::Configure(test())));
    bench.upload(&pulse());
    for _ in 0..300 {
        bench.board.step();
    }
    let Reply::Rejected { obstacle, .. } = bench.ask(Command::Event(Event::Arm)) else {
        panic!("armed");
    };
    assert_eq!(obstacle, Some(Obstacle::NotCalibrated));
    done(&bench.ask(Command::Calibrate(1, Calibration::nominal(&CODES))));
    for _ in 0..300 {
        bench.board.step();
    }
    done(&bench.ask(Command::Event(Event::Arm)));
}

#[test]
fn a_test_of_which_a_load_cell_is_off_by_a_kilonewton_is_not_started() {
    let mut test = test();
    test.config.limits.force_stands_m = Some(7e-3);
    done(&Bench::armed(test.clone(), 0.0).ask(Command::Event(Event::Start)));
    let mut bench = Bench::armed(test, 1000.0);
    let (name, said) = refused(bench.ask(Command::Event(Event::Start)));
    assert_eq!(name, NotReady::Strained.name());
    assert!(said.contains("half of limits.force_stands_m"), "{said}");
    assert_eq!(bench.board.mode(), Mode::Armed);
}
