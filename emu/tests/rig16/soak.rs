//! Tests one after the other on one board for as long as wanted, with trips, resets and crashes: nothing is dropped, no bit
//! differs, and the last period is as exact as the first. On this image, since its output holds its value while the chip is
//! reset; the chip's own output floats, and the rig would go to the end of its stroke.

use crate::desk::{Bench, Desk, PERIOD_NS, TABLE_1};
use emu::{InjectedFault, Log, LoggedEvent, PlannedFault};
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::summary::TestVerdict;
use experiment::trace::Trace;
use link::command::Command;
use link::status::StartCause;
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{BoardBench, Operator};
use outerloop_core::{Event, Mode};
use std::path::Path;
use std::time::Instant;

/// Control steps with PERMIT high from one reset or crash to the next, so that a test that trips fits in between; each further
/// part of a soak has more, so that they come at other instants of a test.
const BETWEEN: u64 = 45_000;
const MORE_A_PART: u64 = 1234;

/// How the program ends, in turn: the reset button, or a crash.
const ENDS: [(InjectedFault, StartCause); 3] = [
    (InjectedFault::Reset, StartCause::Pin),
    (InjectedFault::Drill(1), StartCause::Watchdog),
    (InjectedFault::Drill(2), StartCause::Watchdog),
];

/// Counts of the tests by their outcome.
#[derive(Debug, Default, PartialEq)]
struct Outcomes {
    completed: u32,
    tripped: u32,
    reset: u32,
}

/// A test that runs to its end, or one that exceeds its force limit.
fn experiment(trips: bool) -> Experiment {
    let mut test = TestFile::parse(TABLE_1, "test.toml", Path::new(""), &[]).unwrap();
    if trips {
        test.config.limits.force_n = Some(2500.0);
    }
    Experiment::new(test, &near_fault(), None).unwrap()
}

struct Soak {
    desk: Desk,
    whole: Experiment,
    trips: Experiment,
    outcomes: Outcomes,
    /// Which part of a soak, from 0.
    part: usize,
    /// The board's time since power-up.
    now_s: f64,
}

impl Soak {
    fn new(board_s: u64, part: usize) -> Self {
        let between = BETWEEN + MORE_A_PART * part as u64;
        let ends = (0..)
            .zip(ENDS.iter().cycle().skip(part))
            .map(|(i, (fault, _))| PlannedFault {
                after_steps: (i + 1) * between,
                fault: *fault,
            });
        let desk = Desk::with(Bench {
            longest_s: 2 * board_s + 60,
            then: ends.take((board_s * 2000 / between) as usize + 1).collect(),
            ..Bench::default()
        });
        Self {
            desk,
            whole: experiment(false),
            trips: experiment(true),
            outcomes: Outcomes::default(),
            part,
            now_s: 0.0,
        }
    }

    /// The laboratory's log since the last call, and whether the board was reset in that time; checks that this was as planned.
    fn seen(&mut self) -> (Log, bool) {
        let status = self.desk.status();
        // Taken, since hours of it would fill the memory.
        let log = std::mem::take(&mut *self.desk.log.lock().unwrap());
        assert_eq!(log.violations, []);
        let is_reset = |(_, seen): &(u64, LoggedEvent)| *seen == LoggedEvent::Reset;
        let was_reset = log.seen.iter().any(is_reset);
        if was_reset {
            let (_, cause) = ENDS[(self.part + self.outcomes.reset as usize) % ENDS.len()];
            assert_eq!((status.started, status.mode), (cause, Mode::Idle));
            assert_eq!(status.last_crash.is_some(), cause == StartCause::Watchdog);
            assert!(!status.permit);
            self.outcomes.reset += 1;
        }
        if let Some(last) = log.triggers_ns.last() {
            self.now_s = 1e-9 * *last as f64;
        }
        // Nothing is saved: after a reset the board must be calibrated again.
        if !status.calibrated {
            self.desk.calibrate();
        }
        (log, was_reset)
    }

    /// Runs one test and checks the board afterwards; returns whether it was reset.
    fn test(&mut self, trips: bool) -> bool {
        let experiment = if trips { &self.trips } else { &self.whole };
        let ideal = experiment.ideal().unwrap();
        let plan = PlannedMotion::of(experiment, &ideal);
        // One connection throughout: a reset leaves answers behind that nobody waits for.
        let spare = self.desk.connection();
        let pc = std::mem::replace(&mut self.desk.pc, spare);
        let bench = BoardBench::new(pc, plan, Operator::not_asked());
        let method = experiment.test.config.compensation.kind;
        let run = experiment.run_on(&bench, method, &ideal, false, None::<Trace>);
        self.desk.pc = bench.into_connection();
        let (log, was_reset) = self.seen();
        if was_reset {
            return true;
        }
        self.judge(&run.expect("a test"), trips);
        let period_ns = log.triggers_ns.windows(2).map(|w| w[1] - w[0]);
        let (shortest, longest) = (period_ns.clone().min(), period_ns.max());
        assert!(
            shortest >= Some(PERIOD_NS - 22) && longest <= Some(PERIOD_NS + 22),
            "{shortest:?} to {longest:?} ns"
        );
        let timing = self.desk.status().timing;
        assert!(
            timing.shortest_period_cycles >= 83_997
                && timing.longest_period_cycles <= 84_003
                && timing.overruns == 0,
            "{timing:?}"
        );
        false
    }

    fn judge(&mut self, run: &JudgedRun, trips: bool) {
        let board = run.summary.board.as_ref().expect("a board");
        let wrong = (board.steps_lost, board.steps_different, board.steps_dropped);
        assert_eq!(wrong, (0, 0, Some(0)), "{:?}", self.outcomes);
        let (verdict, count) = match trips {
            false => (TestVerdict::Completed, &mut self.outcomes.completed),
            true => (TestVerdict::Tripped, &mut self.outcomes.tripped),
        };
        assert_eq!(run.summary.verdict, verdict, "{}", run.summary.sentence());
        *count += 1;
        if trips {
            self.desk.order(Command::Event(Event::Clear));
        }
    }
}

/// Interval of progress reports, s of the board's time, so that a soak that is cut off has shown something.
const SAID_EVERY_S: f64 = 600.0;

/// Runs for `board_s` of the board's time, s.
fn soaked(board_s: u64, part: usize) -> Outcomes {
    let (began, mut soak) = (Instant::now(), Soak::new(board_s, part));
    let say = |soak: &Soak| {
        let (board_s, wall_s) = (soak.now_s, began.elapsed().as_secs_f64());
        println!(
            "{:.2} h of the board's time in {:.2} h, {:.2} times as fast as the clock: {:?}; nothing dropped, no bit different",
            board_s / 3600.0,
            wall_s / 3600.0,
            board_s / wall_s,
            soak.outcomes
        );
    };
    let mut at_rest = true;
    let mut said_s = 0.0;
    while soak.now_s < board_s as f64 {
        at_rest &= !soak.seen().1;
        // After a reset or a trip the specimen's force may exceed the smaller limit, which would block arming.
        let trips = at_rest && soak.outcomes.completed > 2 * soak.outcomes.tripped;
        at_rest = !soak.test(trips) && !trips;
        if soak.now_s > said_s + SAID_EVERY_S {
            say(&soak);
            said_s = soak.now_s;
        }
    }
    say(&soak);
    soak.outcomes
}

#[test]
fn a_minute_of_tests_with_a_reset_and_a_crash_loses_nothing() {
    let seen = soaked(60, 0);
    assert!(
        seen.completed >= 2 && seen.tripped >= 1 && seen.reset >= 2,
        "{seen:?}"
    );
}

#[test]
#[ignore = "nightly: hours"]
fn hours_of_tests_with_trips_resets_and_crashes_lose_nothing() {
    let asked = |name: &str, usual: u32| {
        let said = std::env::var(name).ok();
        said.map_or(usual, |n| {
            n.parse()
                .unwrap_or_else(|_| panic!("{name} = {n}: accepted is a whole number"))
        })
    };
    let minutes = asked("OUTERLOOP_SOAK_MINUTES", 8 * 60);
    // The first part runs with every push.
    let part = asked("OUTERLOOP_SOAK_PART", 1);
    let seen = soaked(60 * u64::from(minutes), part as usize);
    assert!(
        seen.completed > minutes && seen.tripped > minutes / 3 && seen.reset > minutes,
        "{seen:?}"
    );
}
