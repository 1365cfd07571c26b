//! What 16 bits are for: a test that uses a small part of a long stroke.

use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::TestVerdict;
use experiment::trace::Trace;
use outerloop_cli::board::emulated::{Emulated, EmulatedRig};
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{BoardBench, Connection, Operator, Timeouts, calibrate};
use std::path::Path;

/// Table 1 over +-250 mm.
const HALF_M: f32 = 0.25;

#[test]
fn over_250_mm_the_error_is_within_5_percent_of_the_one_without_converters() {
    let text = include_str!("../../../examples/table1.toml");
    let bits = ["board.converter_bits=16".to_owned()];
    let test = TestFile::parse(text, "table1.toml", Path::new(""), &bits).unwrap();
    let experiment = Experiment::new(test, &near_fault(), Some(8.0)).unwrap();
    let ideal = experiment.ideal().unwrap();
    let method = experiment.test.config.compensation.kind;
    let without = experiment
        .run(method, &ideal, 1, false, None::<Trace>)
        .unwrap();

    let plan = PlannedMotion::of(&experiment, &ideal);
    let limits = plan.without_board(&experiment.test.config.limits);
    let laboratory = EmulatedRig::of(&experiment.test, 1)
        .sized_for(&limits, &plan)
        .over(HALF_M);
    let emulator = Path::new(env!("CARGO_BIN_EXE_emu"));
    let port = Emulated::with(emulator, &laboratory).unwrap();
    let mut connection = Connection::new(port, Timeouts::BOARD);
    calibrate(&mut connection, laboratory.calibration).unwrap();
    let bench = BoardBench::new(connection, plan, Operator::not_asked()).with_bits(Some(16));
    let run = experiment
        .run_on(&bench, method, &ideal, true, None::<Trace>)
        .unwrap();

    let (summary, plain) = (&run.summary, &without.summary);
    println!(
        "16 bits over +-250 mm: eps_rms {:.4}, without converters {:.4}",
        summary.eps_rms, plain.eps_rms
    );
    println!("{}", summary.board.as_ref().unwrap().sentence());
    assert_eq!(summary.verdict, TestVerdict::Completed);
    assert!((summary.eps_rms / plain.eps_rms - 1.0).abs() < 0.05);
    let board = summary.board.as_ref().unwrap();
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    // The command read back: half a code of each converter, plus the steps of the error feedback.
    let off_m = board.further.as_ref().unwrap().command_off_m.unwrap();
    assert!(off_m < 3.0 * 0.5 / 65_536.0, "{off_m}");
}
