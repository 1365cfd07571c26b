//! A bare board with four wires on a desk (docs/desk.md): what it does, row by row, each with its limit.

pub mod incident;

use super::bench::BoardBench;
use super::connection::BoardConnection;
use super::limits::PlannedMotion;
use super::operator::Operator;
use super::orders::{calibrate, clear, done, event, identify, save, status};
use super::setup::{Hold, ready};
use crate::terminal::interrupt;
use experiment::Experiment;
use experiment::failure::Failure;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::{Summary, TestVerdict};
use experiment::trace::Response;
use link::reply::Identity;
use link::status::Timing;
use link::{Calibration, CodeRange, Command};
use outerloop_core::{Event, Method, Prediction};
use schemars::JsonSchema;
use serde::Serialize;
use std::path::Path;

/// The test of the desk.
const TEST: &str = include_str!("../../../examples/desk.toml");

/// Full scale of the inputs: force over displacement is the stiffness of the test.
const HALF_M: f32 = 0.05;
const FULL_N: f32 = 7900.0;

/// Largest accepted deviation of a control period from its nominal length, cycles.
const PERIOD_OFF_CYCLES: u32 = 100;

/// Length of the test of each method, s.
const METHOD_S: f64 = 0.25;

/// Cycles of each method's most expensive step by the model of the chip (docs/methods-validation.md), with one storey in
/// the laboratory. This is the loop alone: the time that the board measures includes sampling and command output.
pub const MODEL_CYCLES: [(&str, u32); 30] = [
    ("none", 1180),
    ("eq14-unguarded", 1258),
    ("eq14", 1311),
    ("paper", 1436),
    ("lagrange", 1686),
    ("darby", 1865),
    ("model-prediction", 1389),
    ("phase-lead", 1381),
    ("mcs", 1619),
    ("feedforward-feedback", 1404),
    ("afp", 1594),
    ("inverse", 1357),
    ("adaptive-inverse", 1542),
    ("ats", 1834),
    ("amb", 1847),
    ("hydraulic", 2096),
    ("ahmadizadeh", 1994),
    ("tangent", 1873),
    ("paper+lagrange", 1937),
    ("paper+darby", 2105),
    ("paper+model-prediction", 1644),
    ("paper+phase-lead", 1640),
    ("paper+mcs", 1874),
    ("paper+feedforward-feedback", 1659),
    ("paper+afp", 1837),
    ("paper+inverse", 1615),
    ("paper+adaptive-inverse", 1797),
    ("paper+ats", 2087),
    ("paper+amb", 2102),
    ("paper+hydraulic", 2351),
];

/// What the desk rehearses: every method, and `paper` behind each predictor, the most expensive combinations.
pub fn methods() -> Vec<Method> {
    let predictors = Prediction::ALL.iter().copied();
    let pairs = predictors
        .filter(|p| *p != Prediction::None)
        .map(|p| Method::Paper.behind(p));
    Method::ALL.into_iter().chain(pairs).collect()
}

/// Number of saves that fills a sector of 128 KiB with slots of 2 KiB once.
const SAVES: u32 = 66;

/// Steps within which a stopped test has ended.
const STOPPED_STEPS: u32 = 8000;

/// The calibration of a board with four wires, for its `codes`.
pub fn calibration(codes: &CodeRange) -> Calibration {
    Calibration::over(HALF_M, FULL_N, codes)
}

/// The desk's test, for `seconds`, at `rate_hz`.
///
/// # Errors
/// A length or a rate that no test can have.
pub fn experiment(seconds: f64, rate_hz: u32) -> Result<Experiment, Failure> {
    let rate = [format!("loop.rate_hz={rate_hz}")];
    let test = TestFile::parse(TEST, "examples/desk.toml", Path::new(""), &rate)?;
    Experiment::new(test, &near_fault(), Some(seconds))
}

/// The verdict on a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RowVerdict {
    /// The result is as required.
    Good,
    /// The result is not as required, or there is none because it failed.
    Bad,
    /// It was not done; `found` says why.
    NotDone,
}

/// A row of the page.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct DeskRow {
    /// What was done.
    pub what: String,
    /// The result, or why there is none.
    pub found: String,
    /// The required result; empty for a row that was not done.
    pub limit: String,
    /// The verdict.
    pub verdict: RowVerdict,
}

impl DeskRow {
    /// A row of a result, or of the reason for a failure.
    fn of(what: String, limit: &str, found: Result<(String, bool), Failure>) -> Self {
        let (found, good) = found.unwrap_or_else(|why| (why.to_string(), false));
        Self {
            what,
            found,
            limit: limit.into(),
            verdict: if good {
                RowVerdict::Good
            } else {
                RowVerdict::Bad
            },
        }
    }

    /// Something that was not done.
    pub fn not_done(what: &str, why: &str) -> Self {
        Self {
            what: what.into(),
            found: why.into(),
            limit: String::new(),
            verdict: RowVerdict::NotDone,
        }
    }
}

/// The board's timing of its periods and steps in words, and whether it meets the limits.
fn timed(timing: &Timing, dropped: u32) -> (String, bool) {
    let off = |cycles: u32| cycles.abs_diff(timing.period_cycles);
    let (short, long) = (timing.shortest_period_cycles, timing.longest_period_cycles);
    let exact = off(short).max(off(long)) <= PERIOD_OFF_CYCLES;
    let found = format!(
        "period {short} to {long} cycles of {}; step {} at worst, {} on average; {} overruns, {dropped} steps not sent",
        timing.period_cycles, timing.worst_step_cycles, timing.mean_step_cycles, timing.overruns
    );
    (found, exact && timing.overruns == 0 && dropped == 0)
}

/// The board at rest at `rate_hz` for `seconds`.
pub fn idle(board: &mut BoardConnection, rate_hz: u32, seconds: f64) -> DeskRow {
    let found = (|| {
        let experiment = experiment(1.0, rate_hz)?;
        configure(board, &experiment)?;
        // The period in which the rate changes fits neither rate: timing counts from the second command on.
        configure(board, &experiment)?;
        pass(board, (seconds * f64::from(rate_hz)) as u32)?;
        let now = status(board)?;
        Ok(timed(&now.timing, now.dropped_steps))
    })();
    let what = format!("idle at {rate_hz} Hz for {seconds} s");
    DeskRow::of(what, "+-100 cycles, none late, none lost", found)
}

/// The fastest control rate of a board, Hz, that divides its timer's clock.
pub fn fastest_hz(identity: &Identity) -> u32 {
    let divides = |hz: &u32| identity.timer_hz.is_multiple_of(*hz);
    let rates = (1..=identity.fastest_rate_hz).rev();
    rates.into_iter().find(divides).unwrap_or(identity.rate_hz)
}

/// The ideal response of a test and its planned motion.
fn planned(experiment: &Experiment) -> Result<(Response, PlannedMotion), Failure> {
    let ideal = experiment.ideal()?;
    let plan = PlannedMotion::of(experiment, &ideal);
    Ok((ideal, plan))
}

fn configure(board: &mut BoardConnection, experiment: &Experiment) -> Result<(), Failure> {
    let (_, plan) = planned(experiment)?;
    let mut config = experiment.test.config.clone();
    config.limits = plan.without_board(&config.limits);
    let (_, config) = ready(board, (&config, Hold::Storeys), &plan, (None, None))?;
    done(board, "configure", &Command::Configure(config.into())).map(drop)
}

/// Waits for this many steps.
fn pass(board: &mut BoardConnection, steps: u32) -> Result<(), Failure> {
    let mut seen = 0;
    while seen < steps {
        if interrupt::asked() {
            return Err(Failure::test("given up"));
        }
        seen += board.steps()?.len() as u32;
    }
    Ok(())
}

/// A test with `method` for `seconds` over the four wires; gives the board back.
fn test(
    board: BoardConnection,
    method: Method,
    seconds: f64,
) -> (BoardConnection, Result<Summary, Failure>) {
    let planned = experiment(seconds, 2000).and_then(|e| Ok((planned(&e)?, e)));
    match planned {
        Err(why) => (board, Err(why)),
        Ok(((ideal, plan), experiment)) => {
            let bench = BoardBench::new(board, plan, Operator::not_asked());
            let run = experiment.run_on(&bench, method, &ideal, false, ());
            let mut board = bench.into_connection();
            let cleared = clear(&mut board);
            (board, run.and_then(|run| cleared.map(|()| run.summary)))
        }
    }
}

/// A test for each of `methods`: the board rehearses each before it accepts it, and times every step.
pub fn each_method(
    mut board: BoardConnection,
    methods: &[Method],
) -> (BoardConnection, Vec<DeskRow>) {
    let mut rows = Vec::new();
    for &method in methods {
        let (back, summary) = test(board, method, METHOD_S);
        board = back;
        let what = format!("{method} for {METHOD_S} s");
        rows.push(match summary {
            Err(why) if why.to_string().contains(outerloop_core::NOT_BUILT_IN) => {
                DeskRow::not_done(&what, "not done: the image was built without it")
            }
            summary => DeskRow::of(
                what,
                "keeps its deadline, no bit different",
                summary.map(|s| beside_the_model(method, judged(&s, false))),
            ),
        });
    }
    (board, rows)
}

/// Adds the model's cycles of the method.
fn beside_the_model(method: Method, (found, good): (String, bool)) -> (String, bool) {
    let mut model = MODEL_CYCLES.iter();
    let of_method = model.find(|(name, _)| *name == method.name());
    let model = of_method.map_or("none".into(), |(_, cycles)| cycles.to_string());
    (
        format!("{found}; the model of the step alone: {model}"),
        good,
    )
}

/// The whole test.
pub fn whole_test(board: BoardConnection, seconds: f64) -> (BoardConnection, DeskRow) {
    let (board, summary) = test(board, Method::default(), seconds);
    let row = DeskRow::of(
        format!("a whole closed loop, {seconds} s over the four wires"),
        "completed, nothing lost, no bit different",
        summary.map(|s| judged(&s, true)),
    );
    (board, row)
}

/// The result of a test, and whether the PC computed the same bits for all of it.
fn judged(summary: &Summary, whole: bool) -> (String, bool) {
    let Some((on, timing)) = summary.board.as_ref().and_then(|b| Some((b, b.timing?))) else {
        return (summary.sentence(), false);
    };
    let dropped = on.steps_dropped.unwrap_or(0);
    let (mut found, exact) = timed(&timing, dropped);
    if whole {
        found = format!(
            "{}: eps_rms {:.3} %, peak {:.2} mm, {} steps proven; {found}",
            summary.verdict.name(),
            summary.eps_rms * 100.0,
            summary.peak_displacement_m * 1e3,
            on.steps_received - on.steps_different
        );
    }
    let ended = !whole || summary.verdict == TestVerdict::Completed;
    let proven = (on.steps_lost, on.steps_different) == (0, 0);
    let lost = format!(
        "; {} steps lost, {} different",
        on.steps_lost, on.steps_different
    );
    if !proven {
        found += &lost;
    }
    let trip = summary.trip.map(|fault| format!("; tripped on {fault}"));
    let found = found + &trip.clone().unwrap_or_default();
    (found, ended && proven && exact && trip.is_none())
}

/// Saves until a sector is full and is erased. The board is not calibrated, and no save makes it look calibrated.
pub fn saves(board: &mut BoardConnection) -> DeskRow {
    let found = (|| {
        configure(board, &experiment(1.0, 2000)?)?;
        for _ in 0..SAVES {
            save(board)?;
        }
        let now = status(board)?;
        Ok(timed(&now.timing, now.dropped_steps))
    })();
    let what = format!("{SAVES} saves at 2000 Hz, a sector erased among them");
    DeskRow::of(what, "+-100 cycles, none late, none lost", found)
}

/// Takes the desk's calibration back, so that no rig on this board can be armed with it.
pub fn forget(board: &mut BoardConnection) -> DeskRow {
    let found = (|| {
        let codes = identify(board)?.codes;
        calibrate(board, Calibration::placeholder(&codes))?;
        let is_calibrated = status(board)?.calibrated;
        Ok((format!("calibrated: {is_calibrated}"), !is_calibrated))
    })();
    let what = "the calibration of the desk is taken back".into();
    DeskRow::of(what, "calibrated: false", found)
}

/// After a failure: stops a running test, and takes the calibration back.
fn give_up(board: &mut BoardConnection) {
    // If the board does not do this either, the row already says that it failed.
    let _ = event(board, Event::Stop).and_then(|_| pass(board, STOPPED_STEPS));
    let _ = clear(board);
    forget(board);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The desk calibrates the board itself; these are copied by a person who does it by hand.
    #[test]
    fn the_calibrations_on_the_page_are_those_that_the_desk_goes_by() {
        let page = include_str!("../../../docs/desk.md");
        let blocks = page.split("```toml\n").skip(1);
        let copied: Vec<Calibration> = blocks
            .map(|block| toml::from_str(block.split("```").next().unwrap()).unwrap())
            .collect();
        // Two conversions of 12 bits, added; 16 bits.
        let boards = [(8190, 4095), (u16::MAX, u16::MAX)];
        assert_eq!(copied.len(), boards.len());
        for (copied, (sensor_top, command_top)) in copied.iter().zip(boards) {
            let made = calibration(&CodeRange {
                sensor_top,
                sensor_rail: 0,
                sensor_spare: 0,
                command_top,
                command_spare: 0,
            });
            for (copied, made) in [
                (copied.displacement, made.displacement),
                (copied.force, made.force),
                (copied.command, made.command),
            ] {
                // To the digits that a person copies.
                let off = (copied.per_code / made.per_code - 1.0).abs();
                assert!(off < 5e-5, "{copied:?} for {made:?}");
                assert_eq!(copied.zero_code, made.zero_code);
            }
        }
    }
}
