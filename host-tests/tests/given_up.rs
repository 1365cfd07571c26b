//! Ctrl-C while a board approaches the start position of a test, of a commissioning signal or of a served model: it ends the
//! approach, and the board is idle without permission. Ctrl-C in a signal, or on the way to a model's target: the rig slows down
//! first. A signal handler is installed once per process, so each of these tests runs in its own.
#![allow(missing_docs)]
#![cfg(unix)]

use experiment::Experiment;
use experiment::bench::Played;
use experiment::failure::Failure;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::trace::{AnyRecord, TestObserver, Trace};
use host_tests::loopback::Loopback;
use link::command::{CommissioningSignal, SignalShape};
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{self, BoardBench, Connection, Operator, Port, Timeouts, Trajectory};
use outerloop_cli::serve::{Mover, Stop, serve_on_board};
use outerloop_cli::terminal::interrupt;
use outerloop_core::Mode;
use plant::Rig;
use std::path::Path;
use std::process::Command;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// How far from the start the rig was left, mm, and how long the approach takes, s.
const OFF_MM: f64 = 5.0;
const WAY_S: f64 = 10.0;

/// Control steps after power-up at which Ctrl-C is pressed, during that approach, or else in full motion.
const PRESSED: u64 = 6000;

/// Set in a process that runs one of these tests alone.
const ALONE: &str = "OUTERLOOP_GIVEN_UP_ALONE";

/// State when Ctrl-C was pressed: whether it was sent, the board's mode and its PERMIT.
type Pressed = (bool, Mode, bool);

/// True in a separate process for the test of this name; otherwise runs it in one, where it must pass.
fn is_alone(name: &str) -> bool {
    if std::env::var_os(ALONE).is_some() {
        return true;
    }
    let mut alone = Command::new(std::env::current_exe().unwrap());
    let ended = alone.args(["--exact", name]).env(ALONE, "1").output();
    let said = String::from_utf8(ended.unwrap().stdout).unwrap();
    // A failure or an unknown test name ends otherwise.
    assert!(said.contains("test result: ok. 1 passed"), "{said}");
    false
}

fn test() -> TestFile {
    let text = format!(
        "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
         [loop]\napproach_m_per_s = {}\n[plant.actuator]\nkind = 'delay'\ndelay_ms = 4\n[plant.specimen]\n\
         kind = 'linear'\n\
         [excitation]\npeak_response_mm = 20\nduration_s = 6\n",
        OFF_MM * 1e-3 / WAY_S
    );
    TestFile::parse(&text, "t.toml", Path::new(""), &[]).unwrap()
}

/// A calibrated board whose rig stands there; Ctrl-C is pressed after [`PRESSED`] steps.
fn standing_at<P: Port>(
    test: &TestFile,
    at_mm: f64,
    port: impl FnOnce(Loopback) -> P,
) -> (Connection<P>, Receiver<Pressed>) {
    let storeys = &test.config.structure.stiffness_n_per_m;
    let rig = Rig::new(&test.plant, storeys, test.config.timing.rate_hz, 1).unwrap();
    let mut loopback: Loopback = Loopback::standing_at(rig, [at_mm * 1e-3]);
    let (pressed, was) = channel();
    let presses = move |loopback: &mut Loopback| {
        let id = std::process::id().to_string();
        let kill = Command::new("kill").args(["-INT", &id]).status();
        pressed
            .send((
                kill.unwrap().success(),
                loopback.board.mode(),
                loopback.board.hardware.board.permit,
            ))
            .unwrap();
        // Another thread handles it.
        std::thread::sleep(Duration::from_millis(300));
    };
    loopback.incidents.push_back((PRESSED, Box::new(presses)));
    let [wired] = loopback.board.hardware.board.wired;
    let mut connection = Connection::new(port(loopback), Timeouts::BOARD);
    board::calibrate(&mut connection, wired).unwrap();
    (connection, was)
}

/// The same away from its start, so that Ctrl-C comes during the approach.
fn off_the_start(test: &TestFile) -> (Connection<Loopback>, Receiver<Pressed>) {
    standing_at(test, OFF_MM, |loopback| loopback)
}

/// A rig for an external model behind such a board.
fn served_at(at_mm: f64) -> (Box<dyn Mover>, Receiver<Pressed>) {
    let mut test = test();
    (
        test.config.limits.displacement_m,
        test.config.limits.force_n,
    ) = (Some(0.03), Some(7e3));
    let (connection, was) = standing_at(&test, at_mm, |l| Box::new(l) as Box<dyn Port>);
    let nobody = Operator::not_asked();
    // As `outerloop serve` does.
    interrupt::watch_rig();
    let rig = serve_on_board(&test, connection, nobody, false, true, None);
    (rig.unwrap(), was)
}

/// The approach was given up with the sentence `said`, and nothing moves any more.
fn assert_given_up(
    why: Failure,
    said: &str,
    mut connection: Connection<Loopback>,
    was: &Receiver<Pressed>,
) {
    assert_eq!(why, Failure::test(said));
    assert_eq!(was.try_recv(), Ok((true, Mode::Approaching, true)));
    let now = board::status(&mut connection).unwrap();
    assert_eq!((now.mode, now.permit, now.trip), (Mode::Idle, false, None));
}

#[test]
fn ctrl_c_ends_the_approach_and_the_board_is_idle_without_permission() {
    if !is_alone("ctrl_c_ends_the_approach_and_the_board_is_idle_without_permission") {
        return;
    }
    let test = test();
    let experiment = Experiment::new(test.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let (connection, was) = off_the_start(&test);

    let plan = PlannedMotion::of(&experiment, &ideal);
    let bench = BoardBench::new(connection, plan, Operator::not_asked());
    let method = test.config.compensation.kind;
    let run = experiment.run_on(&bench, method, &ideal, false, None::<Trace>);
    let Err(why) = run else {
        panic!("it goes on");
    };
    let said = "the approach to the start was given up, and the board is idle";
    assert_given_up(why, said, bench.into_connection(), &was);
}

#[test]
fn ctrl_c_ends_the_approach_before_a_commissioning_signal_too() {
    if !is_alone("ctrl_c_ends_the_approach_before_a_commissioning_signal_too") {
        return;
    }
    let test = test();
    let (mut connection, was) = off_the_start(&test);
    // Its limits, which follow from the signal, allow the rig's position.
    let sine = Trajectory::Formula(CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Sine { frequency_hz: 0.5 },
        amplitude_m: 0.01,
        seconds: 4.0,
    });
    let nobody = Operator::not_asked();
    let played = board::commission(&mut connection, &test, (&sine, 0), &nobody, &mut ());
    let Err(why) = played else {
        panic!("it goes on");
    };
    let said = "the approach to zero was given up, and the board is idle";
    assert_given_up(why, said, connection, &was);
}

#[test]
fn ctrl_c_ends_the_approach_of_a_served_rig_too() {
    if !is_alone("ctrl_c_ends_the_approach_of_a_served_rig_too") {
        return;
    }
    let (mut rig, was) = served_at(OFF_MM);
    let said = "the approach to the start was given up, and the board is idle";
    assert_eq!(rig.begin(), Err(Failure::test(said)));
    assert_eq!(was.try_recv(), Ok((true, Mode::Approaching, true)));
    rig.end().unwrap();
    assert!(!rig.permit());
}

#[test]
fn ctrl_c_stops_a_served_rig_on_its_way_to_a_target() {
    if !is_alone("ctrl_c_stops_a_served_rig_on_its_way_to_a_target") {
        return;
    }
    let (mut rig, was) = served_at(0.0);
    rig.begin().unwrap();
    // Forty seconds away.
    assert_eq!(rig.go_to(&[20e-3]), Err(Stop::Operator));
    assert_eq!(was.try_recv(), Ok((true, Mode::Running, true)));
    rig.end().unwrap();
    assert!(!rig.permit());
    let trace = rig.take_trace().unwrap();
    assert!((3000..6200).contains(&trace.len()), "{}", trace.len());
}

/// Every command of a signal, m.
#[derive(Default)]
struct Commands(Vec<f32>);

impl TestObserver for Commands {
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        self.0.push(record.command_m[0]);
    }
}

#[test]
fn ctrl_c_in_a_commissioning_signal_stops_it_on_the_ramp_and_keeps_what_came() {
    if !is_alone("ctrl_c_in_a_commissioning_signal_stops_it_on_the_ramp_and_keeps_what_came") {
        return;
    }
    let mut test = test();
    // So gentle that the ramp is many codes long.
    test.config.timing.hold_deceleration_m_per_s2 = 0.5;
    let (mut connection, was) = standing_at(&test, 0.0, |loopback| loopback);
    // Ctrl-C comes some 2.8 s after its start, at 19 mm/s.
    let sine = Trajectory::Formula(CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Sine { frequency_hz: 0.4 },
        amplitude_m: 0.01,
        seconds: 4.0,
    });
    let nobody = Operator::not_asked();
    let mut seen = Commands::default();
    let played = board::commission(&mut connection, &test, (&sine, 0), &nobody, &mut seen).unwrap();
    assert_eq!(was.try_recv(), Ok((true, Mode::Commissioning, true)));
    assert_eq!(played.early.as_deref(), Some(Played::BY_HAND));
    // Of 8000 steps, those until Ctrl-C but for the ones before the start.
    assert!((4000..6000).contains(&played.steps), "{}", played.steps);
    let now = board::status(&mut connection).unwrap();
    assert_eq!((now.mode, now.permit, now.trip), (Mode::Idle, false, None));
    // From its speed to a standstill: v^2 / 2a further, within three codes of 24 um.
    let [before_m, last_m] = *seen.0.last_chunk().unwrap();
    let speed_m_per_s = f64::from(last_m - before_m) * test.config.timing.rate_hz;
    let deceleration = test.config.timing.hold_deceleration_m_per_s2;
    let way_m = speed_m_per_s * speed_m_per_s.abs() / (2.0 * deceleration);
    let identity = board::identify(&mut connection).unwrap();
    let stands_m = identity.calibration.displacement.quantity(now.codes[0]);
    let went_m = f64::from(stands_m - last_m);
    println!(
        "stopped after {} steps at {speed_m_per_s} m/s: {went_m} m further, of {way_m}",
        played.steps
    );
    assert!(
        way_m.abs() > 0.2e-3 && (went_m - way_m).abs() < 75e-6,
        "{went_m} of {way_m} m"
    );
}
