//! The bytes of every frame, as boards and programs of this version know them. Two builds of one version that differ in a
//! byte misread each other in silence; so a change of any of these bytes has to raise [`link::VERSION`]. What is only added,
//! a method or a fault with a number of its own, does not: a board without it says so.
//!
//! `OUTERLOOP_GOLDEN=write cargo test -p link --test golden` writes the file anew, with lines added or under a new version.
#![allow(missing_docs)]

use heapless::Vec;
use link::channel::{Calibration, CodeRange};
use link::command::{BoardTest, Channel, CommissioningSignal, SignalShape};
use link::frame::{Decoder, DecoderCounts, Frame, FrameKind, checksum};
use link::message::Message;
use link::reply::{Identity, NumberedReply, Obstacle, RefusedParameter, Reply, cut};
use link::status::{CrashCause, CrashReport, NamedCause, StartCause, Status, Timing, WatchStatus};
use link::telemetry::StepReport;
use link::{Command, Input, Telemetry, VERSION};
use outerloop_core::config::{ActuatorTimes, Filter, Secant};
use outerloop_core::coupled::{
    Bounds, CoupledSettings, Coupler, EstimatorSettings, Parameter, Plant, SteadyObserver,
    TrackerSettings, VibrationMode,
};
use outerloop_core::watch::{
    Actions, Cause, Corrections, Declared, DeclaredActuator, ErrorLimit, Instructions, PARTS, State,
};
use outerloop_core::{Config, Event, Fault, Method, Mode, Pace, Prediction, Structure, Trip};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

const CODES: CodeRange = CodeRange {
    sensor_top: 8190,
    sensor_rail: 8,
    sensor_spare: 600,
    command_top: 4095,
    command_spare: 300,
};

fn config() -> Config {
    Config::shear_frame([1000.0, 900.0], [158e3, 120e3], [0.02, 0.03])
}

/// Each of three actuators with its own times.
fn config_of_three() -> Config {
    let mut config = Config::shear_frame([1000.0; 3], [158e3; 3], [0.02; 3]);
    let times = |ms| ActuatorTimes::each(ms).unwrap();
    config.compensation.delay_ms = times(&[4.0, 6.0, 9.0]);
    config.estimation.delay_ms = times(&[3.0, 5.0, 8.0]);
    config.estimation.lag_ms = times(&[1.0, 1.5, 2.0]);
    config
}

/// Two actuators on one coupler, every number another one.
fn coupled() -> CoupledSettings<2> {
    let mode = |omega_rad_per_s, participation| VibrationMode {
        omega_rad_per_s,
        damping_ratio: 0.04,
        participation,
    };
    let observer = |first: f64| SteadyObserver {
        modes: [
            (mode(12.0, first), [0.5, 3.0]),
            (mode(58.0, 0.3), [0.25, 7.0]),
        ]
        .into_iter()
        .collect(),
    };
    let bounds = |position: f64| Bounds {
        position,
        speed_per_s: 0.75,
        force: 9e3,
        tracking: 0.003,
    };
    CoupledSettings {
        structure: Structure {
            mass: [[1000.0, 2.0], [2.0, 60.0]],
            damping: [[600.0, 5.0], [5.0, 90.0]],
            stiffness: [[208e3, 60e3], [60e3, 192e3]],
            numerical_stiffness: [[104e3, 30e3], [30e3, 96e3]],
            influence: [1.0, 0.125],
            physical: 2,
            physical_mass_kg: [12.0, 1.5],
        },
        tracker: TrackerSettings {
            coupler: Coupler {
                pin_x_m: [0.25, 0.26],
                pin_y_m: [-0.13, 0.12],
            },
            estimate: EstimatorSettings {
                plant: Plant {
                    gain: [[0.86, 0.13], [0.14, 0.93]],
                    slow_pole_rad_per_s: [16.5, 22.0],
                    fast_pole_rad_per_s: [250.0, 116.0],
                    lead_s: [[0.001, 0.002], [0.0015, 0.0025]],
                    path_lead_s: [[0.0, 0.053], [0.0, 0.032]],
                    natural_rad_per_s: 500.0,
                    damping_ratio: 0.62,
                    delay_s: [0.002, 0.003],
                },
                spreads: [
                    (Parameter::SlowPole(1), 0.06),
                    (Parameter::FastPole(0), 0.05),
                    (Parameter::Lead(0, 1), 0.04),
                    (Parameter::PathLead(1, 1), 0.03),
                    (Parameter::NaturalFrequency, 0.02),
                    (Parameter::Gain(1, 0), 0.01),
                ]
                .into_iter()
                .collect(),
                noise_m: 2e-5,
                period_s: 1e-3,
            },
            inverse: true,
            target: [observer(-0.25), observer(0.625)],
            ahead_s: 0.0,
            trust_reading_hz: 5.0,
        },
        interface: [bounds(0.04), bounds(0.05)],
    }
}

const ERROR_LIMIT: ErrorLimit = ErrorLimit {
    largest: 0.05,
    damping_ratio: 0.02,
    duration_s: 30.0,
    planned_rms: [0.25; PARTS],
};

/// What the watch of an actuator is told, every number another one.
fn instructions(error_limit: Option<ErrorLimit>) -> Instructions {
    Instructions {
        declared: Declared {
            rate_hz: 2000.0,
            omega_rad_per_s: 6.5,
            peak_m: 0.04,
            stiffness_n_per_m: 158e3,
            stiffness_tolerance: 0.02,
            actuator: DeclaredActuator {
                gain: 1.01,
                delay_s: 6e-3,
                lag_s: 8e-3,
                offset_m: 1e-4,
                tolerances: [5e-3, 7e-4, 2e-4],
            },
            alone: true,
            has_actuator: true,
            has_specimen: false,
            elastic: true,
            damping_n_s_per_m: 300.0,
            mass_kg: 12.0,
            specimen_tolerances: [10.0, 1.0, 5.0],
            force_gain: 0.99,
            force_offset_n: 15.0,
            noise: [4e-5, 6.0],
        },
        actions: Actions {
            hold: true,
            trip: true,
            correct: Corrections {
                lateness: true,
                gain: false,
                late_sensor: true,
            },
            error_limit,
        },
    }
}

fn commands() -> std::vec::Vec<(String, Command)> {
    let signal = |shape| {
        Command::Signal(Some(CommissioningSignal {
            actuator: 2,
            shape,
            amplitude_m: 0.01,
            seconds: 20.0,
        }))
    };
    let mut all = vec![
        ("identify", Command::Identify),
        ("status", Command::Status),
        ("configure", Command::Configure(config().into())),
        (
            "configure three actuators",
            Command::Configure(config_of_three().into()),
        ),
        (
            "configure two coupled actuators",
            Command::Configure(BoardTest {
                config: config(),
                coupled: Some(coupled()),
            }),
        ),
        (
            "calibrate",
            Command::Calibrate(0, Calibration::over(0.05, 1e4, &CODES)),
        ),
        (
            "zero displacement",
            Command::Zero {
                actuator: 0,
                channel: Channel::Displacement,
                value: 0.5,
            },
        ),
        (
            "zero force",
            Command::Zero {
                actuator: 2,
                channel: Channel::Force,
                value: -1.5,
            },
        ),
        ("save", Command::Save),
        (
            "motion",
            Command::Motion {
                points: 16_384,
                interval_s: 0.005,
                checksum: 0x0102_0304,
            },
        ),
        (
            "points",
            Command::Points {
                first: 300,
                points: [1.0, -2.0].into_iter().collect(),
            },
        ),
        ("signal none", Command::Signal(None)),
        ("signal constant", signal(SignalShape::Constant)),
        (
            "signal sine",
            signal(SignalShape::Sine { frequency_hz: 1.0 }),
        ),
        (
            "signal chirp",
            signal(SignalShape::Chirp {
                from_hz: 0.1,
                to_hz: 20.0,
            }),
        ),
        ("history", Command::History(15)),
        ("pace none", Command::Pace(None)),
        ("pace stop and go", Command::Pace(Some(Pace::StopAndGo))),
        ("pace continuous", Command::Pace(Some(Pace::Continuous))),
        (
            "target of one",
            Command::Target([0.01].into_iter().collect()),
        ),
        (
            "target of three",
            Command::Target([0.01, -0.02, 0.03].into_iter().collect()),
        ),
    ]
    .into_iter()
    .map(|(name, command)| (name.to_owned(), command))
    .collect::<std::vec::Vec<_>>();
    for (name, error_limit) in [("", None), (" to an error", Some(ERROR_LIMIT))] {
        let told = instructions(error_limit);
        all.push((format!("watch{name}"), Command::Watch(1, told)));
    }
    for secant in [Secant::Command, Secant::Measured] {
        let mut config = config();
        config.compensation.secant = secant;
        all.push((
            format!("configure secant {secant:?}"),
            Command::Configure(config.into()),
        ));
    }
    for filter in [Filter::Off, Filter::Kalman, Filter::LowPass] {
        let mut config = config();
        config.estimation.kind = filter;
        all.push((
            format!("configure filter {filter:?}"),
            Command::Configure(config.into()),
        ));
    }
    all.extend(Event::ALL.map(|event| (format!("event {event:?}"), Command::Event(event))));
    all
}

fn identity(others: &[Calibration]) -> Identity {
    Identity {
        board: cut("board"),
        version: cut("1.2.3"),
        commit: cut("abc"),
        clock_hz: 168_000_000,
        timer_hz: 84_000_000,
        rate_hz: 2000,
        fastest_rate_hz: 3000,
        output_delay_us: 40.0,
        max_points: 16_384,
        max_dof: 3,
        deadline_cycles: 4200,
        codes: CODES,
        calibration: Calibration::over(0.05, 1e4, &CODES),
        others: others.iter().copied().collect(),
        inputs: [
            Input::CommandReadBack(0),
            Input::CommandReadBack(2),
            Input::SecondDisplacement,
            Input::HeadAcceleration,
        ]
        .into_iter()
        .collect(),
        input_span_v: [-10.0, 10.0],
    }
}

fn status(trip: Option<Trip>, started: StartCause, last_crash: Option<CrashReport>) -> Status {
    Status {
        tick: 70_000,
        mode: Mode::Tripped,
        trip,
        permit: true,
        configured: true,
        calibrated: false,
        points: 200,
        crystal_ok: true,
        converters_ok: true,
        codes: [8190, 7],
        other_codes: Vec::new(),
        timing: Timing {
            period_cycles: 84_000,
            shortest_period_cycles: 83_999,
            longest_period_cycles: 84_001,
            worst_step_cycles: 900,
            mean_step_cycles: 800,
            overruns: 1,
        },
        link: DecoderCounts {
            good: 5,
            malformed: 4,
            corrupt: 3,
            too_long: 2,
            other_version: 1,
        },
        dropped_steps: 3,
        stack_bytes: 4096,
        watch: None,
        started,
        last_crash,
    }
}

fn replies() -> std::vec::Vec<(String, Reply)> {
    let trip = |fault| Trip {
        fault,
        axis: 1,
        value: 1.0,
        limit: 0.5,
        tick: 9,
    };
    let rejected = |obstacle| Reply::Rejected {
        mode: Mode::Idle,
        event: Some(Event::Arm),
        obstacle: Some(obstacle),
    };
    let mut all = vec![
        ("identity".to_owned(), Reply::Identity(identity(&[]))),
        (
            "identity with three actuators".to_owned(),
            Reply::Identity(identity(&[
                Calibration::over(0.1, 2e4, &CODES),
                Calibration::over(0.2, 5e4, &CODES),
            ])),
        ),
        (
            "refused".to_owned(),
            Reply::Refused(RefusedParameter::new("name", 1.5, "accepted")),
        ),
        (
            "zeroed".to_owned(),
            Reply::Zeroed {
                code: 4095.5,
                spread: 3,
            },
        ),
        (
            "record".to_owned(),
            Reply::Record([1, u32::MAX].into_iter().collect()),
        ),
        ("expected".to_owned(), Reply::Expected(128)),
        (
            "wrong sum".to_owned(),
            Reply::WrongSum {
                received: 0x0102_0304,
            },
        ),
        ("unknown".to_owned(), Reply::Unknown),
    ];
    for mode in Mode::ALL {
        let name = format!("done {mode:?}");
        all.push((name, Reply::Done { tick: 1, mode }));
    }
    for fault in Fault::ALL {
        let status = status(Some(trip(fault)), StartCause::Power, None);
        all.push((format!("status {fault:?}"), Reply::Status(status)));
    }
    let mut three = status(None, StartCause::Power, None);
    three.other_codes = [[1, 2], [300, 400]].into_iter().collect();
    all.push(("status of three actuators".to_owned(), Reply::Status(three)));
    let mut watched = status(None, StartCause::Power, None);
    let late = NamedCause {
        actuator: 2,
        cause: Cause::ActuatorLate,
        value: 12.5,
        sd: 0.5,
        corrected: 11.5,
    };
    watched.watch = Some(WatchStatus {
        state: State::Named,
        since_step: 18_752,
        named: core::iter::once(late).collect(),
        held: true,
        blocks: 5000,
        worst_cycles: 30_000,
        mean_cycles: 9000,
    });
    all.push(("status of the watch".to_owned(), Reply::Status(watched)));
    for (started, cause) in [
        (StartCause::Power, CrashCause::Panic),
        (StartCause::BrownOut, CrashCause::HardFault),
        (StartCause::Pin, CrashCause::StackOverflow),
        (StartCause::Software, CrashCause::Starved),
        (StartCause::Watchdog, CrashCause::Silent),
        (StartCause::Watchdog, CrashCause::ClockStopped),
        (StartCause::Watchdog, CrashCause::LowSupply),
        (StartCause::Watchdog, CrashCause::PermitStays),
    ] {
        let words = CrashReport {
            cause,
            tick: 77,
            mode: Mode::Running,
            text: cut("text"),
        };
        let status = status(None, started, Some(words));
        let name = format!("status {started:?} {cause:?}");
        all.push((name, Reply::Status(status)));
    }
    for obstacle in [
        Obstacle::Fault(Fault::AdcRail),
        Obstacle::NotCalibrated,
        Obstacle::NotConfigured,
        Obstacle::NothingToRun,
        Obstacle::Crystal,
        Obstacle::Converters,
    ] {
        all.push((format!("rejected {obstacle:?}"), rejected(obstacle)));
    }
    all
}

fn telemetry() -> Telemetry {
    let step = StepReport {
        flags: 0x0102_0304,
        displacement: 0x0506,
        force: 0x0708,
        others: [[0x1314, 0x1516], [0x1718, 0x191a]],
        command_m: 1.0,
        added_damping_n_s_per_m: -2.0,
        energy_j: 0.5,
        digest: 0x090a_0b0c,
        inputs: [0x0d0e, 0x0f10, 0x1112, 0x1b1c, 0x1d1e],
    };
    Telemetry {
        first_tick: 70_000,
        steps: [step; 2].into_iter().collect(),
    }
}

/// Of a long body the number of bytes and the check sum are compared.
fn line(text: &mut String, name: &str, wire: &[u8]) {
    let mut decoder = Decoder::new();
    let mut body: Vec<u8, 1000> = Vec::new();
    for &byte in wire {
        if let Some(frame) = decoder.push(byte) {
            body.extend_from_slice(frame.body).unwrap();
        }
    }
    let shown = if body.len() <= 64 {
        body.iter().fold(String::new(), |mut all, byte| {
            write!(all, "{byte:02x}").unwrap();
            all
        })
    } else {
        let sum = checksum(body.iter().copied());
        format!("{} bytes, CRC-32 {sum:08x}", body.len())
    };
    writeln!(text, "{name}: {shown}").unwrap();
}

fn all_bytes() -> String {
    let mut text = format!("version {VERSION}\n");
    for (name, command) in commands() {
        line(
            &mut text,
            &format!("command {name}"),
            &command.encode(7).unwrap(),
        );
    }
    // Force law and predictor. What a program brings itself is in no list, and its number travels all the same.
    let own = [
        Method::Own,
        Method::OwnForce,
        Method::OwnForce.behind(Prediction::Own),
    ];
    for method in Method::ALL.into_iter().chain(own) {
        let mut room = [0; 2];
        let bytes = postcard::to_slice(&method, &mut room).unwrap();
        writeln!(text, "method {method}: {:02x}{:02x}", bytes[0], bytes[1]).unwrap();
    }
    for (name, reply) in replies() {
        let answer = NumberedReply {
            request: 513,
            reply,
        };
        line(
            &mut text,
            &format!("reply {name}"),
            &answer.encode(7).unwrap(),
        );
    }
    for (actuators, inputs) in [(1, 0), (1, 1), (1, 2), (1, 3), (2, 0), (3, 2), (3, 5)] {
        let frame = Frame {
            kind: FrameKind::Telemetry,
            sequence: 7,
            body: &telemetry().encode(actuators, inputs),
        };
        let name = match actuators {
            1 => format!("telemetry with {inputs} further inputs"),
            _ => format!("telemetry of {actuators} actuators with {inputs} further inputs"),
        };
        line(&mut text, &name, &frame.encode().unwrap());
    }
    // Around each body: version, kind, number and check sum, coded without a zero, and the zero.
    let whole = Command::History(15).encode(0x0102).unwrap();
    let hex = |byte: &u8| format!("{byte:02x}");
    let hex: String = whole.iter().map(hex).collect();
    writeln!(text, "whole frame of command history: {hex}").unwrap();
    text
}

#[test]
fn no_byte_of_the_link_changes_without_its_version() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden.txt");
    let known = std::fs::read_to_string(&path).unwrap_or_default();
    let now = all_bytes();
    if known == now {
        return;
    }
    let lines = |text: &str| -> BTreeSet<String> { text.lines().map(str::to_owned).collect() };
    let (before, after) = (lines(&known), lines(&now));
    let gone: std::vec::Vec<_> = before.difference(&after).collect();
    let new: std::vec::Vec<_> = after.difference(&before).collect();
    let same_version = known.lines().next() == now.lines().next();
    assert!(
        gone.is_empty() || !same_version,
        "bytes of the link have changed and its version has not: raise link::VERSION, then write link/tests/golden.txt \
         anew; gone: {gone:#?}, new: {new:#?}"
    );
    let write = std::env::var("OUTERLOOP_GOLDEN").is_ok_and(|v| v == "write");
    assert!(
        write,
        "link/tests/golden.txt has not all bytes: OUTERLOOP_GOLDEN=write writes it; new: {new:#?}"
    );
    std::fs::write(&path, now).unwrap();
}
