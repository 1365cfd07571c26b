//! A test stopped by a person: the board slows down on its deceleration ramp, PERMIT falls at standstill, and no record is
//! lost.

use crate::desk::{Desk, PERIOD_NS, TABLE_1, codes, fine};
use emu::LoggedEvent;
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::summary::TestVerdict;
use experiment::trace::{AnyRecord, TestObserver};
use link::Calibration;
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{BoardBench, Operator};
use outerloop_core::{Event, Mode};
use std::path::Path;

/// Steps after which the person waits for the rig to move fast enough, and how fast that is, m per step.
const AFTER: usize = 6000;
const MOVING_M: f32 = 40e-6;

/// Presses stop once, in full motion.
#[derive(Default)]
struct Hand {
    seen: usize,
    /// The last command, and its change since the one before, m.
    command_m: f32,
    way_m: f32,
    pressed: bool,
}

impl TestObserver for Hand {
    fn on_step(&mut self, record: &AnyRecord<'_>) {
        self.seen += 1;
        self.way_m = record.command_m[0] - self.command_m;
        self.command_m = record.command_m[0];
    }

    fn requested_event(&mut self) -> Option<Event> {
        let now = !self.pressed && self.seen >= AFTER && self.way_m.abs() >= MOVING_M;
        self.pressed |= now;
        now.then_some(Event::Stop)
    }
}

#[test]
fn a_test_that_is_stopped_by_hand_slows_down_on_its_ramp_and_keeps_its_record() {
    let test = TestFile::parse(TABLE_1, "test.toml", Path::new(""), &[]).unwrap();
    let experiment = Experiment::new(test.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let mut desk = Desk::new(None);
    desk.calibrate();
    let plan = PlannedMotion::of(&experiment, &ideal);
    let bench = BoardBench::new(desk.connection(), plan, Operator::not_asked());
    let mut hand = Hand::default();
    let method = test.config.compensation.kind;
    let run = experiment
        .run_on(&bench, method, &ideal, true, &mut hand)
        .unwrap();
    drop(bench);

    let summary = &run.summary;
    assert_eq!(
        summary.verdict,
        TestVerdict::Stopped,
        "{}",
        summary.sentence()
    );
    let kept = run.trace.expect("a record").len();
    assert_eq!((summary.steps, hand.seen), (kept, kept));
    assert!((AFTER..20_000).contains(&kept), "{kept} steps");
    let board = summary.board.as_ref().expect("a board");
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));

    let status = desk.status();
    assert_eq!((status.mode, status.permit), (Mode::Idle, false));
    assert_eq!(status.trip, None);
    let seen = desk.log().seen;
    let permits = seen.iter().enumerate().filter_map(|(i, (_, s))| match s {
        LoggedEvent::Permit(high) => Some((i, *high)),
        _ => None,
    });
    let permits: Vec<(usize, bool)> = permits.collect();
    let [(_, true), (low, false)] = permits[..] else {
        panic!("PERMIT: {permits:?}");
    };
    let code = |s: &(u64, LoggedEvent)| match s.1 {
        LoggedEvent::Command(code) => Some(code),
        _ => None,
    };
    let before: Vec<u16> = seen[..low].iter().filter_map(code).collect();
    // It has been at standstill for a while when PERMIT falls; the output may alternate between two codes.
    let stands = *before.last().expect("commands");
    let last = &before[before.len() - 20..];
    assert!(last.iter().all(|now| now.abs_diff(stands) <= 1), "{last:?}");

    // From its speed to standstill at the deceleration: a distance of v^2 / 2a, within two codes and a step.
    let step_s = PERIOD_NS as f64 * 1e-9;
    let speed_m_per_s = f64::from(hand.way_m) / step_s;
    let deceleration = test.config.timing.hold_deceleration_m_per_s2;
    let expected_m = speed_m_per_s.abs() * speed_m_per_s / (2.0 * deceleration);
    let line = Calibration::nominal(&codes()).command;
    let way_m = f64::from(line.quantity(stands) - hand.command_m);
    println!(
        "stopped after {kept} steps at {:.0} mm/s: {:.2} mm to a standstill, {:.2} at {deceleration} m/s^2",
        speed_m_per_s * 1e3,
        way_m * 1e3,
        expected_m * 1e3
    );
    let two_codes_m = 2.0 * f64::from(line.per_code.abs()) * f64::from(fine());
    let a_step_more_m = f64::from(hand.way_m.abs());
    let bound_m = two_codes_m + a_step_more_m;
    assert!(expected_m.abs() > 4.0 * bound_m, "{expected_m} m");
    assert!(
        (way_m - expected_m).abs() < bound_m,
        "{way_m} of {expected_m} m"
    );
}
