//! The bench of a test as `outerloop run --emulated` sets it up.

use experiment::Experiment;
use experiment::judged::JudgedRun;
use experiment::trace::{Response, Trace};
use link::Status;
use outerloop_cli::board::emulated::{Emulated, EmulatedRig};
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{BoardBench, Connection, Operator, Timeouts, calibrate, status};
use std::path::Path;

/// An emulated board calibrated to the rig of `experiment`, unattended.
fn bench(experiment: &Experiment, ideal: &Response) -> BoardBench<Emulated> {
    let plan = PlannedMotion::of(experiment, ideal);
    let limits = plan.without_board(&experiment.test.config.limits);
    let laboratory = EmulatedRig::of(&experiment.test, 1).sized_for(&limits, &plan);
    let emulator = Path::new(env!("CARGO_BIN_EXE_emu"));
    let port = Emulated::with(emulator, &laboratory).unwrap();
    let mut connection = Connection::new(port, Timeouts::BOARD);
    calibrate(&mut connection, laboratory.calibration).unwrap();
    BoardBench::new(connection, plan, Operator::not_asked())
}

/// Runs the test of `experiment` on that board with its own compensation; every step is received and recomputed. Also returns
/// the board's status afterwards.
pub fn run(experiment: &Experiment, ideal: &Response) -> (JudgedRun, Status) {
    let method = experiment.test.compensation();
    let bench = bench(experiment, ideal);
    let run = experiment
        .run_on(&bench, method, ideal, true, None::<Trace>)
        .unwrap();
    let status = status(&mut bench.into_connection()).unwrap();
    (run, status)
}
