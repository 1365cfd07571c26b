//! Ctrl-C while a board goes to its start position: it ends the approach, and the board is idle without permission. In a
//! program of its own, since a signal is caught once for all.
#![allow(missing_docs)]
#![cfg(unix)]

use experiment::Experiment;
use experiment::failure::Failure;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::trace::Trace;
use host_tests::loopback::Loopback;
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{BoardBench, Connection, Operator, Timeouts, calibrate, status};
use outerloop_core::Mode;
use plant::Rig;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// How far from the start the rig was left, and how long its way there takes, s.
const OFF_MM: f64 = 5.0;
const WAY_S: f64 = 10.0;

/// Control steps after power-up at which somebody presses Ctrl-C: on that way.
const PRESSED: u64 = 6000;

#[test]
fn ctrl_c_ends_the_approach_and_the_board_is_idle_without_permission() {
    let text = format!(
        "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
         [loop]\napproach_m_per_s = {}\n[plant.actuator]\nkind = 'delay'\ndelay_ms = 4\n[plant.specimen]\n\
         kind = 'linear'\n\
         [excitation]\npeak_response_mm = 20\nduration_s = 6\n",
        OFF_MM * 1e-3 / WAY_S
    );
    let test = TestFile::parse(&text, "t.toml", Path::new(""), &[]).unwrap();
    let experiment = Experiment::new(test.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let storeys = &test.config.structure.stiffness_n_per_m;
    let rig = Rig::new(&test.plant, storeys, test.config.timing.rate_hz, 1).unwrap();
    let mut board: Loopback = Loopback::standing_at(rig, [OFF_MM * 1e-3]);
    let (pressed, was) = std::sync::mpsc::channel();
    let presses = move |board: &mut Loopback| {
        let id = std::process::id().to_string();
        let kill = Command::new("kill").args(["-INT", &id]).status();
        pressed
            .send((
                kill.unwrap().success(),
                board.board.mode(),
                board.board.hardware.board.permit,
            ))
            .unwrap();
        // Another thread hears of it.
        std::thread::sleep(Duration::from_millis(300));
    };
    board.mishaps.push_back((PRESSED, Box::new(presses)));
    let [wired] = board.board.hardware.board.wired;
    let mut connection = Connection::new(board, Timeouts::BOARD);
    calibrate(&mut connection, wired).unwrap();

    let plan = PlannedMotion::of(&experiment, &ideal);
    let bench = BoardBench::new(connection, plan, Operator::not_asked());
    let method = test.config.compensation.kind;
    let run = experiment.run_on(&bench, method, &ideal, false, None::<Trace>);
    let Err(Failure::Test(said)) = run else {
        panic!("it goes on");
    };
    assert!(
        said.contains("the approach to the start was given up"),
        "{said}"
    );
    assert_eq!(was.try_recv(), Ok((true, Mode::Approaching, true)));
    let now = status(&mut bench.into_connection()).unwrap();
    assert_eq!((now.state, now.permit, now.trip), (Mode::Idle, false, None));
}
