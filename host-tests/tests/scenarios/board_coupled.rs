//! Two actuators on one coupler behind the firmware's own station, served to an external model: the PC's side, over frames.

use crate::board_served::{QUICK, session_of};
use experiment::files::test::TestFile;
use firmware::sim::CODES;
use host_tests::loopback::{FaultInjection, Loopback};
use link::Calibration;
use outerloop_cli::board::{self, BoardConnection, Connection, Operator, Port};
use outerloop_cli::serve::{Mover, SessionVerdict, serve_on_board};
use plant::coupled::CoupledRig;
use std::path::Path;

/// The example with the specimen as declared, for converters of 12 bits, whose codes are 61 um wide.
fn test() -> TestFile {
    let text = include_str!("../../../examples/coupled-frame.toml");
    let set = [
        "plant.coupled.specimen.springs=[]",
        "coupled.noise_mm=0.1",
        "coupled.limits.frozen_m=1e-3",
        "coupled.limits.stale_steps=50",
        "serve.settle_ms=100",
        "serve.average_ms=100",
    ];
    let set = set.map(str::to_owned);
    TestFile::parse(text, "coupled-frame.toml", Path::new(""), &set).unwrap()
}

/// A board whose first two actuators are calibrated, prepared by `prepare`.
fn served(test: &TestFile, prepare: impl FnOnce(&mut Loopback<3>)) -> Box<dyn Mover> {
    let part = test.coupled_part().unwrap();
    let (coupler, sensors) = (&part.declared.coupler, &test.plant.sensors);
    let rate_hz = test.config.timing.rate_hz;
    let rig = CoupledRig::new(&part.rig, coupler, sensors, rate_hz, 1).unwrap();
    let mut loopback = Loopback::<3>::new(rig);
    let wired = Calibration::over(0.125, 25e3, &CODES);
    loopback.board.hardware.board.wired = [wired; 3];
    prepare(&mut loopback);
    let port: Box<dyn Port> = Box::new(loopback);
    let mut connection: BoardConnection = Connection::new(port, QUICK);
    for actuator in 0..2 {
        board::calibrate_one(&mut connection, actuator, wired).unwrap();
    }
    serve_on_board(test, connection, Operator::not_asked(), false, true, None).unwrap()
}

const PATH: [[f64; 2]; 4] = [[0.01, 0.0], [0.01, 0.02], [-0.01, 0.02], [-0.01, -0.02]];

#[test]
fn force_and_moment_are_the_specimens_and_every_step_is_proven() {
    let test = test();
    let (forces, summary, trace) = session_of(&test, served(&test, |_| {}).as_mut(), &PATH);
    let why = summary.sentences();
    assert_eq!(summary.verdict, SessionVerdict::Completed, "{why}");
    assert!(!summary.permit && summary.targets == 4, "{why}");
    let board = summary.board.as_ref().unwrap();
    assert_eq!((board.steps_lost, board.steps_different), (0, 0), "{why}");
    assert_eq!(trace.len(), summary.steps);
    assert!(trace.interface.is_some());
    println!("{why}");
    let stiffness = test.coupled_part().unwrap().declared.specimen.stiffness;
    for (force, [x, turn]) in forces.iter().zip(PATH) {
        let own = stiffness.map(|row| row[0] * x + row[1] * turn);
        println!("{force:?} of {own:?}");
        // The mean of a hundred readings, with force codes 12 N wide.
        for (j, room) in [(0, 6.0), (1, 6.0)] {
            assert!((force[j] - own[j]).abs() < room, "{force:?} of {own:?}");
        }
    }
}

#[test]
fn a_lost_step_ends_it_since_readings_of_the_actuators_are_not_those_of_x_and_rotation() {
    let test = test();
    let mut rig = served(&test, |board| {
        let lose: FaultInjection<3> = Box::new(|b| b.drop_frames = 1);
        board.incidents.push_back((2000, lose));
    });
    let (forces, summary, _) = session_of(&test, rig.as_mut(), &PATH);
    assert_eq!(
        summary.verdict,
        SessionVerdict::RigLost,
        "{}",
        summary.sentences()
    );
    assert!(
        summary
            .reason
            .unwrap()
            .contains("where x and the rotation are")
    );
    assert!(!summary.permit && forces.len() < PATH.len());
}
