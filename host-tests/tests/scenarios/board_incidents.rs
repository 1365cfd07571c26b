//! Faults between PC and board in the middle of a test or a signal: the PC reports them, and keeps what it received.

use crate::board_link::{
    chirp, connect, connect_with, loopback, play_to_an_end, run_by, run_on, run_over, test,
};
use experiment::bench::Played;
use experiment::files::test::TestFile;
use experiment::summary::TestVerdict;
use host_tests::loopback::{FaultInjection, Loopback};
use outerloop_cli::board::{Operator, Timeouts, Trajectory};
use outerloop_core::Mode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
use std::sync::mpsc::{Sender, channel};

#[test]
fn a_cut_link_keeps_what_was_received_and_says_so() {
    let t = test(&[]);
    let mut board = loopback(&t);
    board
        .incidents
        .push_back((9000, Box::new(|b| b.cut = true)));
    let run = run_on(&t, board).unwrap();
    assert_eq!(run.summary.trip, Some("link_lost"));
    let kept = run.trace.unwrap().len();
    assert!(kept > 3000 && kept < 9000, "{kept}");
    let said = run.summary.board.unwrap().sentence();
    assert!(
        said.contains("What was received is kept; the link to the board is lost"),
        "{said}"
    );
}

/// A power cycle at this step.
fn without_power_at(t: &TestFile, step: u64) -> (u64, FaultInjection) {
    let t = t.clone();
    (step, Box::new(move |b| *b = loopback(&t)))
}

#[test]
fn a_board_that_starts_again_in_a_test_ends_it_and_what_was_received_is_kept() {
    let t = test(&[]);
    let mut board = loopback(&t);
    board.incidents.push_back(without_power_at(&t, 9000));
    let run = run_on(&t, board).unwrap();
    let (summary, trace) = (run.summary, run.trace.unwrap());
    assert_eq!(summary.trip, Some("link_lost"));
    assert!((3000..9000).contains(&trace.len()), "{}", trace.len());
    let board = summary.board.as_ref().unwrap();
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    let said = board.sentence();
    let why = "the board has started again, and what ran on it is over: its power had been away";
    assert!(said.contains(why), "{said}");
    // The reported time is that of the test, without the time before it.
    let ended_s = trace.len() as f64 / 2000.0;
    let told = format!("Tripped on link_lost after {ended_s:.2} s of the laboratory.");
    assert!(summary.sentence().contains(&told), "{}", summary.sentence());
}

#[test]
fn noise_on_the_line_and_a_board_that_hears_nothing_end_the_test_and_keep_it() {
    let noisy: FaultInjection = Box::new(|b| b.is_noisy = true);
    // It trips by itself, and its telemetry says so, but it answers no command.
    let deaf: FaultInjection = Box::new(|b| b.is_deaf = true);
    for (happens, why) in [
        (noisy, "nothing that can be read came"),
        (deaf, "the board does not answer"),
    ] {
        let t = test(&[]);
        let mut board = loopback(&t);
        board.incidents.push_back((9000, happens));
        // Half a second until the PC's timeout, and another until the board's; the ramp takes a tenth.
        let stands = Arc::new(AtomicBool::new(false));
        let seen = Arc::clone(&stands);
        let look = move |b: &mut Loopback| seen.store(b.board.mode() == Mode::Tripped, Relaxed);
        board.incidents.push_back((11_300, Box::new(look)));
        let run = run_over(&t, connect_with(board, Timeouts::BOARD)).unwrap();
        assert_eq!(run.summary.trip, Some("link_lost"));
        assert!(stands.load(Relaxed), "the test runs on, and nobody sees it");
        assert!(run.trace.unwrap().len() > 3000);
        let said = run.summary.board.unwrap().sentence();
        assert!(said.contains(why), "{said}");
    }
}

#[test]
fn an_emergency_on_the_ramp_behind_a_test_is_told_and_stands() {
    let t = test(&[]);
    let mut board = loopback(&t);
    let steps = Arc::new(AtomicU32::new(0));
    for step in 0..30_000 {
        let steps = Arc::clone(&steps);
        let happen = move |b: &mut Loopback| {
            if b.board.mode() == Mode::Finished && steps.fetch_add(1, Relaxed) == 8 {
                b.board.hardware.broken.stop_pressed = true;
            }
        };
        board.incidents.push_back((step, Box::new(happen)));
    }
    let run = run_on(&t, board).unwrap();
    assert_eq!(
        run.summary.trip,
        Some("emergency_stop"),
        "{}",
        run.summary.sentence()
    );
    assert!(run.trace.unwrap().len() > 11_000);
}

#[test]
fn a_signal_that_the_boards_button_ends_is_not_called_whole() {
    let t = test(&["plant.actuator.delay_ms=1"]);
    let mut board = loopback(&t);
    let press: FaultInjection = Box::new(|b| b.board.hardware.broken.hold_pressed = true);
    board.incidents.push_back((6000, press));
    let played = play_to_an_end(&mut connect(board), &t, &Trajectory::Formula(chirp()));
    let early = played.early.expect("a signal that was ended");
    assert_eq!(early, Played::BY_BUTTON);
    assert!(played.steps > 2000 && played.steps < 10_000);
}

#[test]
fn a_board_that_starts_again_in_a_signal_ends_it() {
    let t = test(&["plant.actuator.delay_ms=1"]);
    let mut board = loopback(&t);
    board.incidents.push_back(without_power_at(&t, 3000));
    let played = play_to_an_end(&mut connect(board), &t, &Trajectory::Formula(chirp()));
    let early = played.early.expect("a signal that was ended");
    assert!(early.contains("has started again"), "{early}");
}

#[test]
fn lost_steps_are_counted_and_the_rest_is_kept() {
    let t = test(&[]);
    let mut board = loopback(&t);
    board
        .incidents
        .push_back((9000, Box::new(|b| b.drop_frames = 3)));
    let run = run_on(&t, board).unwrap();
    let board = run.summary.board.as_ref().unwrap();
    assert_eq!(board.steps_lost, 24);
    assert_eq!(run.summary.verdict, TestVerdict::Completed);
    assert_eq!(run.trace.unwrap().len(), 12_000 - 24);
    assert!(
        board.sentence().contains("24 lost on the way"),
        "{}",
        board.sentence()
    );
}

#[test]
fn a_test_of_which_a_step_came_out_otherwise_is_stopped_on_its_ramp() {
    let t = test(&[]);
    let mut board = loopback(&t);
    board
        .incidents
        .push_back((9000, Box::new(|b| b.wrong_bits = 1)));
    let run = run_on(&t, board).unwrap();
    let board = run.summary.board.as_ref().unwrap();
    assert_eq!(run.summary.verdict, TestVerdict::Stopped);
    assert!(board.steps_lost == 0 && board.steps_different > 0);
    let said = board.sentence();
    assert!(said.contains("worked a step out otherwise"), "{said}");
    let said = run.summary.sentence();
    assert!(said.starts_with("Stopped by the PC, since"), "{said}");
    let steps = run.trace.unwrap().len();
    assert!(steps > 3000 && steps < 9100, "{steps}");
}

/// Runs a test that ends on its ramp, since its energy error is too large; if `pressed`, the emergency stop is pressed in
/// the third step of the ramp. Returns the number of steps on the ramp.
fn ramped(pressed: bool) -> u32 {
    let t = test(&["limits.energy_trip=0.002"]);
    let mut board = loopback(&t);
    let steps = Arc::new(AtomicU32::new(0));
    for step in 0..16_000 {
        let steps = Arc::clone(&steps);
        let happen = move |b: &mut Loopback| {
            if b.board.mode() == Mode::Stopping && steps.fetch_add(1, Relaxed) == 2 {
                b.board.hardware.broken.stop_pressed = pressed;
            }
        };
        board.incidents.push_back((step, Box::new(happen)));
    }
    let run = run_on(&t, board).unwrap();
    assert_eq!(
        run.summary.trip,
        Some("energy_ratio"),
        "{}",
        run.summary.sentence()
    );
    let board = run.summary.board.as_ref().unwrap();
    assert_eq!(
        (board.steps_lost, board.steps_different),
        (0, 0),
        "{pressed}"
    );
    steps.load(Relaxed)
}

#[test]
fn an_emergency_on_the_ramp_ends_it_and_is_worked_out_to_its_last_bit() {
    let (whole, cut_short) = (ramped(false), ramped(true));
    assert_eq!(cut_short, 3);
    assert!(whole > cut_short, "{whole}");
}

#[test]
fn a_test_that_is_held_while_the_keyboard_goes_is_stopped() {
    let t = test(&[]);
    let mut board = loopback(&t);
    let (person, go) = channel();
    let types = |line: &str, person: Sender<String>| -> FaultInjection {
        let line = line.to_owned();
        Box::new(move |_| person.send(line.clone()).unwrap())
    };
    let press =
        |down| -> FaultInjection { Box::new(move |b| b.board.hardware.broken.hold_pressed = down) };
    // The last line drops the keyboard's sender.
    board.incidents.extend([
        (700, types("", person.clone())),
        (800, types("0.2", person.clone())),
        (3000, types("", person)),
        (8000, press(true)),
        (8200, press(false)),
    ]);
    let run = run_by(&t, connect(board), Operator::by(go)).unwrap();
    let summary = run.summary;
    assert_eq!(
        summary.verdict,
        TestVerdict::Stopped,
        "{}",
        summary.sentence()
    );
    let board = summary.board.as_ref().unwrap();
    assert_eq!((summary.trip, board.link.as_ref()), (None, None));
}
