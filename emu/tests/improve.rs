//! The improvement loop on the flashed image: a test on a rig with an undeclared effect, the diagnosis of the board's
//! telemetry, the improved configuration sent to the same board, and the same test again.

use experiment::Experiment;
use experiment::bench::Played;
use experiment::compensation::Compensation;
use experiment::failure::Failure;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::trace::{Response, TestObserver, Trace};
use outerloop_cli::board::emulated::{Emulated, EmulatedRig};
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{
    BoardBench, BoardConnection, Connection, Operator, Port, Timeouts, Trajectory, calibrate,
};
use outerloop_cli::improve::{FirstTest, Improvement, ImprovementOutcome};
use outerloop_cli::site::{ConnectedBoard, RigKind, TestSite};
use outerloop_cli::terminal::Progress;
use outerloop_core::Config;
use plant::RigSpec;
use std::cell::{Cell, RefCell};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

/// A code of 12 bits over +-10 kN is 5 N, as large as the load cell's noise.
const TEST: &str = "
[structure]
mass_kg = 1000
stiffness_n_per_m = 158e3
damping_ratio = 0.02
[loop]
rate_hz = 2000
[compensation]
window_steps = 10
[excitation]
peak_response_mm = 20
duration_s = 8
rest_s = 2
[plant.actuator]
kind = 'delay'
delay_ms = 4
[plant.sensors]
displacement_noise_mm = 0.02
force_noise_n = 5
";

/// An emulated board on the rig of the first test, which is kept.
#[derive(Default)]
struct Boards {
    first: RefCell<Option<(RigSpec, BoardBench<Box<dyn Port>>)>>,
    /// Tests on another rig, on another board.
    others: Cell<usize>,
}

/// A test on a rig without its effect, which is the same for all effects.
struct Reference {
    config: Config,
    rig: RigSpec,
    compensation: Compensation,
    ideal: Response,
    seed: u64,
    run: JudgedRun,
}

/// Each is run once.
static REFERENCES: Mutex<Vec<Reference>> = Mutex::new(Vec::new());

/// A board calibrated to the rig of `experiment`.
fn board(
    experiment: &Experiment,
    ideal: &Response,
    seed: u64,
) -> Result<BoardBench<Box<dyn Port>>, Failure> {
    let plan = PlannedMotion::of(experiment, ideal);
    let connection = connection(&experiment.test, seed)?;
    Ok(BoardBench::new(connection, plan, Operator::not_asked()))
}

fn connection(test: &TestFile, seed: u64) -> Result<BoardConnection, Failure> {
    let laboratory = EmulatedRig::of(test, seed);
    let emulator = Path::new(env!("CARGO_BIN_EXE_emu"));
    let port: Box<dyn Port> = Box::new(Emulated::with(emulator, &laboratory)?);
    let mut connection = Connection::new(port, Timeouts::BOARD);
    calibrate(&mut connection, laboratory.calibration)?;
    Ok(connection)
}

/// The same test on the rig without the effect, on a board of its own.
fn reference(
    experiment: &Experiment,
    compensation: Compensation,
    ideal: &Response,
    seed: u64,
) -> Result<JudgedRun, Failure> {
    let test = &experiment.test;
    let mut references = REFERENCES.lock().unwrap_or_else(PoisonError::into_inner);
    let same = |r: &&Reference| {
        let of_test = (&r.config, &r.rig) == (&test.config, &test.plant);
        of_test && (r.compensation, &r.ideal, r.seed) == (compensation, ideal, seed)
    };
    if let Some(known) = references.iter().find(same) {
        return Ok(known.run.clone());
    }
    let bench = board(experiment, ideal, seed)?;
    let run = experiment.run_on(&bench, compensation, ideal, false, None::<Trace>)?;
    references.push(Reference {
        config: test.config.clone(),
        rig: test.plant.clone(),
        compensation,
        ideal: ideal.clone(),
        seed,
        run: run.clone(),
    });
    Ok(run)
}

impl TestSite for Boards {
    fn kind(&self) -> RigKind {
        RigKind::Emulated
    }

    fn connect(
        &self,
        test: &TestFile,
        _: &PlannedMotion,
        seed: u64,
    ) -> Result<Option<ConnectedBoard>, Failure> {
        Ok(Some((connection(test, seed)?, Operator::not_asked())))
    }

    fn run(
        &self,
        experiment: &Experiment,
        compensation: impl Into<Compensation>,
        ideal: &Response,
        seed: u64,
        keep: bool,
        observer: impl TestObserver,
    ) -> Result<JudgedRun, Failure> {
        let compensation = compensation.into();
        let rig = &experiment.test.plant;
        let mut first = self.first.borrow_mut();
        let (theirs, bench) = match first.take() {
            Some(known) => first.insert(known),
            None => first.insert((rig.clone(), board(experiment, ideal, seed)?)),
        };
        if theirs != rig {
            self.others.set(self.others.get() + 1);
            return reference(experiment, compensation, ideal, seed);
        }
        experiment.run_on(bench, compensation, ideal, keep, observer)
    }

    fn play(
        &self,
        test: &TestFile,
        trajectory: &Trajectory,
        _: u64,
        observer: &mut dyn TestObserver,
    ) -> Result<Played, Failure> {
        let first = self.first.borrow();
        let own = first.as_ref().filter(|(rig, _)| *rig == test.plant);
        let (_, bench) = own.expect("a test runs before a signal");
        bench.play(test, trajectory, observer)
    }
}

/// The improvement of a test on the board; the two tests of the rig with the effect run on one board.
fn story(text: &str) -> Improvement {
    let test = TestFile::parse(text, "test.toml", Path::new(""), &[]).unwrap();
    let declared = test.declared_model().unwrap();
    let experiment = Experiment::new(test, &near_fault(), None).unwrap();
    let boards = Boards::default();
    let progress = Progress::over("near-fault", Improvement::steps(&experiment) as u64);
    let first = FirstTest::run(experiment, &boards, 1, &progress).unwrap();
    let story = Improvement::of(first, &declared, &boards, 1, &progress).unwrap();
    // The test without the effect runs on another.
    assert_eq!(boards.others.get(), 1);
    story
}

/// The improvement, and the error of the test before, after, and without the effect.
fn told(what: &str, more: &str) -> (Improvement, [f64; 3]) {
    let story = story(&format!("{TEST}{more}\n"));
    let possible = story.possible.as_ref().unwrap();
    let eps = [&story.before, &story.after, possible].map(|run| run.summary.eps_rms);
    println!(
        "{what}: found {}, {} designed tests; eps_rms on the board {:.4} before, {:.4} with what was found, {:.4} without \
         the effect; {:?}",
        Improvement::named(&story.diagnosis),
        story.designed.len(),
        eps[0],
        eps[1],
        eps[2],
        story.changes
    );
    for run in [&story.before, &story.after] {
        let board = run.summary.board.as_ref().unwrap();
        assert_eq!((board.steps_lost, board.steps_different), (0, 0), "{what}");
    }
    (story, eps)
}

/// With what the diagnosis finds in the telemetry, the next test on the same board is as good as without the effect.
fn comes_back(what: &str, more: &str) {
    let (story, eps) = told(what, more);
    assert!(!story.changes.is_empty(), "{what}");
    assert!(eps[0] > 1.5 * eps[2], "{what}: {eps:?}");
    assert!(eps[1] < 1.1 * eps[2], "{what}: {eps:?}");
    assert_eq!(
        story.outcome(),
        ImprovementOutcome::Better,
        "{what}: {eps:?}"
    );
}

#[test]
fn an_actuator_that_stands_off_is_sent_elsewhere() {
    comes_back(
        "the actuator stands off",
        "[[plant.effects]]\nname = 'offset'\nchannel = 'actuator'\noffset_mm = 2",
    );
}

#[test]
fn a_displacement_that_reads_off_is_taken_off_once() {
    comes_back("the displacement reads off", "displacement_offset_mm = 2");
}

#[test]
fn a_second_lag_is_sent_ahead_of() {
    comes_back(
        "a second lag",
        "[[plant.effects]]\nname = 'second_lag'\nchannel = 'actuator'\nlag_ms = 4",
    );
}

#[test]
fn an_actuator_that_goes_too_far_is_sent_less_far() {
    comes_back(
        "the actuator goes too far",
        "[[plant.effects]]\nname = 'gain_error'\nchannel = 'actuator'\nerror = 0.05",
    );
}

#[test]
fn a_load_cell_that_reads_too_much_is_divided_by_that() {
    comes_back(
        "the load cell reads too much",
        "[[plant.effects]]\nname = 'gain_error'\nchannel = 'specimen'\nerror = 0.06",
    );
}

/// The whole cycle: an earthquake of 1 mm, read with 12 bits, does not distinguish a lag of 6 ms from a delay; a test designed
/// by the diagnosis and played by the same board does, and the next test is better. The board's noise differs each time; all
/// of 40 such tests on the simulated rig took this course.
#[test]
fn what_a_small_earthquake_leaves_open_is_settled_by_a_test_designed_and_played_on_the_board() {
    let small = TEST.replace("peak_response_mm = 20", "peak_response_mm = 1");
    let limits = "[limits]\ndisplacement_m = 0.03\nvelocity_m_per_s = 0.6\nforce_n = 8000";
    let lag = "[[plant.effects]]\nname = 'lag_error'\nchannel = 'actuator'\nlag_ms = 6";
    let story = story(&format!("{small}{limits}\n{lag}\n"));
    println!(
        "a small earthquake: found {} at first, {} after {} designed tests; eps_rms on the board {:.4} before, {:.4} with what \
         was found",
        Improvement::named(&story.first),
        Improvement::named(&story.diagnosis),
        story.designed.len(),
        story.before.summary.eps_rms,
        story.after.summary.eps_rms
    );
    assert_ne!(Improvement::named(&story.first), "lag_error");
    assert!(!story.designed.is_empty());
    assert_eq!(Improvement::named(&story.diagnosis), "lag_error");
    assert_eq!(story.outcome(), ImprovementOutcome::Better);
}
