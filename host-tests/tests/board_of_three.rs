//! Three actuators on one board: station, service, link and the PC's side, on this machine.
#![allow(missing_docs)]

use firmware::sim::CODES;
use host_tests::loopback::Loopback;
use link::Calibration;
use link::channel::number_of;
use outerloop_cli::board::limits::Plan;
use outerloop_cli::board::{self, BoardBench, Connection, Operator, Patience};
use outerloop_cli::experiment::Experiment;
use outerloop_cli::failure::Failure;
use outerloop_cli::files::near_fault::near_fault;
use outerloop_cli::files::test::TestFile;
use outerloop_cli::judged::Run;
use outerloop_cli::summary::Verdict;
use outerloop_cli::trace::Trace;
use outerloop_core::Fault;
use plant::Rig;
use std::path::Path;
use std::time::Duration;

const QUICK: Patience = Patience {
    answer: Duration::from_millis(50),
    stop: Duration::from_millis(40),
    silence: Duration::from_millis(200),
};

/// The example with three storeys, its strong part, to a peak that converters of 12 bits show well.
fn test(overrides: &[&str]) -> TestFile {
    let text = include_str!("../../examples/three-storey.toml");
    let strong = ["excitation.duration_s=6", "excitation.peak_response_mm=40"];
    let overrides: Vec<String> = strong
        .iter()
        .chain(overrides)
        .map(|s| (*s).into())
        .collect();
    TestFile::parse(text, "three-storey.toml", Path::new(""), &overrides).unwrap()
}

/// Each actuator has sensors and a stroke of its own, one of them the other way round.
fn wired() -> [Calibration; 3] {
    let [first, mut second, mut third] =
        [(0.1, 1e5), (0.2, 1.2e5), (0.15, 8e4)].map(|(m, n)| Calibration::over(m, n, &CODES));
    second.command.per_code *= -1.0;
    second.force.zero_code += 20.0;
    third.displacement.per_code *= -1.0;
    [first, second, third]
}

fn loopback(t: &TestFile) -> Loopback<3> {
    let storeys = &t.config.structure.stiffness_n_per_m;
    let rig = Rig::new(&t.plant, storeys, t.config.timing.rate_hz, 1).unwrap();
    let mut loopback = Loopback::new(rig);
    loopback.board.hardware.board.wired = wired();
    loopback
}

fn run(t: &TestFile, loopback: Loopback<3>, calibrated: usize) -> Result<Run, Failure> {
    let mut connection = Connection::new(loopback, QUICK);
    for (actuator, calibration) in (0..).zip(wired()).take(calibrated) {
        board::calibrate_one(&mut connection, actuator, calibration).unwrap();
    }
    let experiment = Experiment::new(t.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let plan = Plan::of(&experiment, &ideal);
    let bench = BoardBench::new(connection, plan, Operator::nobody())
        .expecting(t.board.calibration.clone());
    let method = t.config.compensation.kind;
    experiment.run_on(&bench, method, &ideal, true, None::<Trace>)
}

#[test]
fn a_whole_test_has_the_bits_of_the_loop_on_the_pc_and_ends_as_on_the_rig_without_a_board() {
    let number = format!("{:08x}", number_of(&wired()));
    let t = test(&[&format!("board.calibration='{number}'")]);
    let on_board = run(&t, loopback(&t), 3).unwrap();
    let board = on_board.summary.board.as_ref().unwrap();
    assert_eq!(on_board.summary.verdict, Verdict::Completed);
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    assert!(board.steps_received > 12_000);

    let experiment = Experiment::new(t.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let method = t.config.compensation.kind;
    let plain = experiment
        .run(method, &ideal, 1, false, None::<Trace>)
        .unwrap();
    let (board, plain) = (on_board.summary.eps_rms, plain.summary.eps_rms);
    println!("eps_rms {board:.4} through converters of 12 bits, {plain:.4} without");
    assert!(board < plain + 0.01, "{board} {plain}");
}

#[test]
fn each_actuators_channels_are_calibrated_before_anything_is_armed() {
    // So small that the range of a board that nobody has calibrated shows it.
    let t = test(&["excitation.peak_response_mm=5"]);
    let Err(Failure::Test(said)) = run(&t, loopback(&t), 2) else {
        panic!("armed");
    };
    assert!(said.contains("nobody has calibrated the board"), "{said}");
}

#[test]
fn a_rail_on_any_actuator_trips_the_test_and_a_converter_out_of_its_range_too() {
    let t = test(&[]);
    for actuator in 0..3 {
        for codes in [[8190, 4095], [4095, 3]] {
            let mut broken = loopback(&t);
            let happen = move |l: &mut Loopback<3>| {
                (
                    l.board.hardware.broken.actuator,
                    l.board.hardware.broken.codes,
                ) = (actuator, Some(codes));
            };
            broken.mishaps.push_back((8000, Box::new(happen)));
            let run = run(&t, broken, 3).unwrap();
            let board = run.summary.board.as_ref().unwrap();
            assert_eq!(board.trip, Some(Fault::AdcRail), "actuator {actuator}");
            assert_eq!(board.steps_different, 0, "actuator {actuator}");
        }
    }
}

#[test]
fn the_last_actuators_force_is_watched_and_named() {
    let t = test(&["limits.force_n=20e3"]);
    let mut pushed = loopback(&t);
    let line = wired()[2].force;
    let code = (30e3 / line.per_code + line.zero_code) as u16;
    let happen = move |l: &mut Loopback<3>| {
        let broken = &mut l.board.hardware.broken;
        (broken.actuator, broken.codes) = (2, Some([4095, code]));
    };
    pushed.mishaps.push_back((8000, Box::new(happen)));
    let run = run(&t, pushed, 3).unwrap();
    let trip = run.summary.trip_detail.unwrap();
    assert_eq!((trip.fault, trip.axis), (Fault::Force, 2));
    assert!((trip.value / 30e3 - 1.0).abs() < 0.01, "{}", trip.value);
    assert_eq!(run.summary.board.as_ref().unwrap().steps_different, 0);
}

#[test]
fn a_test_with_fewer_storeys_in_the_laboratory_than_actuators_is_refused() {
    let t = test(&["structure.physical_storeys=1"]);
    let storeys = test(&[]);
    let Err(Failure::Input(said)) = run(&t, loopback(&storeys), 3) else {
        panic!("armed");
    };
    assert!(
        said.contains("1 storeys in the laboratory") && said.contains("the board has 3"),
        "{said}"
    );
}
