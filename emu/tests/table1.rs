//! The test that `outerloop run --emulated examples/table1.toml` runs, on the flashed image: its strong part, with peaks
//! beyond what a board shows that nobody has calibrated.

use outerloop_cli::board::emulated::{Emulated, Laboratory};
use outerloop_cli::board::limits::Plan;
use outerloop_cli::board::{BoardBench, Connection, Operator, Patience, calibrate};
use outerloop_cli::experiment::Experiment;
use outerloop_cli::files::near_fault::near_fault;
use outerloop_cli::files::test::TestFile;
use outerloop_cli::summary::Verdict;
use outerloop_cli::trace::Trace;
use std::path::Path;

#[test]
fn the_strong_part_of_table_1_on_a_board_that_is_calibrated_to_its_rig() {
    let text = include_str!("../../examples/table1.toml");
    let test = TestFile::parse(text, "table1.toml", Path::new(""), &[]).unwrap();
    let experiment = Experiment::new(test, &near_fault(), Some(8.0)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let method = experiment.test.config.compensation.kind;

    let plan = Plan::of(&experiment, &ideal);
    let limits = plan.without_board(&experiment.test.config.limits);
    let laboratory = Laboratory::of(&experiment.test, 1).sized_for(&limits, &plan);
    let emulator = Path::new(env!("CARGO_BIN_EXE_emu"));
    let port = Emulated::with(emulator, &laboratory).unwrap();
    let mut connection = Connection::new(port, Patience::EMULATED);
    calibrate(&mut connection, laboratory.calibration).unwrap();
    let run = experiment
        .run_on(
            &BoardBench::new(connection, plan, Operator::nobody()),
            method,
            &ideal,
            true,
            None::<Trace>,
        )
        .unwrap();

    let summary = &run.summary;
    println!("{}", summary.sentence());
    assert_eq!(summary.verdict, Verdict::Completed);
    assert!(ideal.peaks_m()[0] > 0.08 && summary.eps_rms < 0.02);
    let board = summary.board.as_ref().unwrap();
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
}
