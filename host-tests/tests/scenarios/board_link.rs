//! The PC's side of the link against the firmware's own station, over frames, with a rig behind converters of 12 bits.

use experiment::Experiment;
use experiment::bench::{OnBoard, Played};
use experiment::failure::Failure;
use experiment::files::near_fault::near_fault;
use experiment::files::recording::SiRecording;
use experiment::files::signal::SignalPoints as PointsOfSignal;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::summary::{Summary, TestVerdict};
use host_tests::loopback::{FaultInjection, Loopback};
use link::command::{CommissioningSignal, SignalShape};
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{self, BoardBench, Connection, Operator, Port, Timeouts, Trajectory};
use plant::Rig;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::channel;
use std::time::Duration;

pub const QUICK: Timeouts = Timeouts {
    answer: Duration::from_millis(200),
    stop: Duration::from_millis(40),
    silence: Duration::from_millis(200),
};

pub fn test(overrides: &[&str]) -> TestFile {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    let text = "[structure]\nmass_kg = 1000\nstiffness_n_per_m = 158e3\ndamping_ratio = 0.02\n\
                [plant.actuator]\nkind = \"delay\"\ndelay_ms = 4\n[plant.specimen]\nkind = \"linear\"\n\
                [excitation]\npeak_response_mm = 20\nduration_s = 6\n";
    TestFile::parse(text, "t.toml", Path::new(""), &overrides).unwrap()
}

pub fn loopback(t: &TestFile) -> Loopback {
    let storeys = &t.config.structure.stiffness_n_per_m;
    Loopback::new(Rig::new(&t.plant, storeys, t.config.timing.rate_hz, 1).unwrap())
}

/// A connection to a board calibrated as it is wired.
pub fn connect(board: Loopback) -> Connection<Loopback> {
    connect_with(board, QUICK)
}

pub fn connect_with(board: Loopback, timeouts: Timeouts) -> Connection<Loopback> {
    let [wired] = board.board.hardware.board.wired;
    let mut connection = Connection::new(board, timeouts);
    board::calibrate(&mut connection, wired).unwrap();
    connection
}

pub fn run_on(t: &TestFile, board: Loopback) -> Result<JudgedRun, Failure> {
    run_over(t, connect(board))
}

pub fn run_over(t: &TestFile, connection: Connection<impl Port>) -> Result<JudgedRun, Failure> {
    run_by(t, connection, Operator::not_asked())
}

pub fn run_by(
    t: &TestFile,
    connection: Connection<impl Port>,
    operator: Operator,
) -> Result<JudgedRun, Failure> {
    let experiment = Experiment::new(t.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let plan = PlannedMotion::of(&experiment, &ideal);
    let bench = BoardBench::new(connection, plan, operator).expecting(t.board.calibration.clone());
    let method = t.config.compensation.kind;
    experiment.run_on(
        &bench,
        method,
        &ideal,
        true,
        None::<experiment::trace::Trace>,
    )
}

/// The board's account of a test that ran to its end with every step recomputed.
fn ran_with_every_bit_proven(summary: &Summary) -> &OnBoard {
    let board = summary.board.as_ref().unwrap();
    assert_eq!(
        summary.verdict,
        TestVerdict::Completed,
        "{}",
        summary.sentence()
    );
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    board
}

/// The board continues without its rig watch, and so does the loop on the PC, whose watch is never late.
#[test]
fn tasks_that_answer_the_rig_watch_too_late_stop_no_test() {
    let t = test(&["watch.correct=['lateness']"]);
    let mut busy = loopback(&t);
    busy.incidents
        .push_back((6000, Box::new(|board| board.away_steps = 60)));
    let run = run_on(&t, busy).unwrap();
    ran_with_every_bit_proven(&run.summary);
}

#[test]
fn a_test_on_a_board_is_worked_out_again_with_the_same_bits_and_ends_as_on_the_plant() {
    let t = test(&[]);
    let run = run_on(&t, loopback(&t)).unwrap();
    let board = ran_with_every_bit_proven(&run.summary);
    assert_eq!(run.summary.steps, 12_000);
    assert_eq!(board.steps_dropped, Some(0));
    assert!(board.steps_received > 12_000);
    let trace = run.trace.unwrap();
    assert_eq!(trace.len(), 12_000);
    assert!(trace.energy_input_j.last().unwrap().abs() > 0.0);

    let experiment = Experiment::new(t.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let method = t.config.compensation.kind;
    let on_plant = experiment
        .run(method, &ideal, 1, false, None::<experiment::trace::Trace>)
        .unwrap();
    // A code of 12 bits over 100 mm is 24 um, 0.12 % of the peak: the two may differ by at most two codes.
    let apart = (run.summary.eps_rms - on_plant.summary.eps_rms).abs();
    println!(
        "eps_rms {} on the board, {} on the plant",
        run.summary.eps_rms, on_plant.summary.eps_rms
    );
    assert!(apart < 0.0024, "{apart}");
}

#[test]
fn each_trip_has_its_name_and_what_was_before_it_is_worked_out_to_its_last_bit() {
    type Case = (
        &'static str,
        &'static [&'static str],
        Option<fn(&mut Loopback)>,
    );
    let cases: [Case; 6] = [
        (
            "emergency_stop",
            &[],
            Some(|b| b.board.hardware.broken.stop_pressed = true),
        ),
        (
            "adc_rail",
            &[],
            Some(|b| b.board.hardware.broken.codes = Some([8190, 4095])),
        ),
        (
            "permit_chain",
            &[],
            Some(|b| b.board.hardware.broken.chain = Some(false)),
        ),
        ("displacement", &["limits.displacement_m=0.012"], None),
        ("force", &["limits.force_n=1500"], None),
        ("tracking", &["limits.tracking_m=0.0005"], None),
    ];
    for (name, overrides, incident) in cases {
        let t = test(overrides);
        let mut board = loopback(&t);
        if let Some(happen) = incident {
            board.incidents.push_back((9000, Box::new(happen)));
        }
        let run = run_on(&t, board).unwrap();
        assert_eq!(run.summary.trip, Some(name), "{}", run.summary.sentence());
        let board = run.summary.board.as_ref().unwrap();
        assert_eq!((board.steps_lost, board.steps_different), (0, 0), "{name}");
        assert!(run.summary.sentence().contains(name));
        assert!(!run.trace.unwrap().is_empty(), "{name}");
    }
}

#[test]
fn a_test_that_the_board_refuses_says_what_it_would_accept() {
    for (overrides, words) in [
        (
            &["loop.rate_hz=1999"][..],
            &["loop.rate_hz = 1999", "whole divisors"][..],
        ),
        (
            &["loop.rate_hz=10000"],
            &["loop.rate_hz = 10000", "carries"],
        ),
    ] {
        let t = test(overrides);
        let Err(Failure::Input(said)) = run_on(&t, loopback(&t)) else {
            panic!("{overrides:?} is accepted");
        };
        for word in words {
            assert!(said.contains(word), "{word} is not in: {said}");
        }
    }
}

#[test]
fn a_tripped_board_is_refused_until_it_is_cleared() {
    let t = test(&["limits.displacement_m=0.012"]);
    let experiment = Experiment::new(t.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let plan = PlannedMotion::of(&experiment, &ideal);
    let bench = BoardBench::new(connect(loopback(&t)), plan, Operator::not_asked());
    let method = t.config.compensation.kind;
    let none = || None::<experiment::trace::Trace>;
    let first = experiment
        .run_on(&bench, method, &ideal, false, none())
        .unwrap();
    assert_eq!(first.summary.verdict, TestVerdict::Tripped);
    let Err(Failure::Test(said)) = experiment.run_on(&bench, method, &ideal, false, none()) else {
        panic!("accepted");
    };
    assert!(said.contains("stands tripped on displacement"), "{said}");
    let mut connection = bench.into_connection();
    board::clear(&mut connection).unwrap();
    let bench = BoardBench::new(connection, plan, Operator::not_asked());
    let again = experiment.run_on(&bench, method, &ideal, false, none());
    assert_eq!(again.unwrap().summary.trip, Some("displacement"));
}

/// A chirp of 10 mm.
pub fn chirp() -> CommissioningSignal {
    CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Chirp {
            from_hz: 0.5,
            to_hz: 10.0,
        },
        amplitude_m: 0.01,
        seconds: 10.0,
    }
}

/// An actuator plays a trajectory to its end, with nobody at the board.
pub fn play_to_an_end(
    connection: &mut Connection<Loopback>,
    t: &TestFile,
    trajectory: &Trajectory,
) -> Played {
    let nobody = Operator::not_asked();
    board::commission(connection, t, (trajectory, 0), &nobody, &mut ()).unwrap()
}

fn play(connection: &mut Connection<Loopback>, t: &TestFile, trajectory: &Trajectory) -> Played {
    let played = play_to_an_end(connection, t, trajectory);
    assert_eq!(played.early, None);
    played
}

#[test]
fn a_designed_signal_is_played_by_the_board_and_refused_beyond_a_limit_before_anything_moves() {
    let t = test(&[]);
    // Half a second of rest, one cycle, half a second of rest, at its own sampling interval.
    let command_m: Vec<f64> = (0..=300)
        .map(|i| match i {
            50..250 => 0.004 * (1.0 - (std::f64::consts::TAU * f64::from(i - 50) / 200.0).cos()),
            _ => 0.0,
        })
        .collect();
    let trajectory = Trajectory::Points(PointsOfSignal {
        interval_s: 0.01,
        command_m: command_m.clone(),
    });
    let mut connection = connect(loopback(&t));
    let played = play(&mut connection, &t, &trajectory);
    let recording = SiRecording::parse("signal.csv", &played.text).unwrap();
    let command = recording.command_m().unwrap();
    assert!((6000..6003).contains(&command.len()), "{}", command.len());
    for (i, wanted) in command_m.iter().enumerate() {
        let sent = command[20 * i];
        // A record's command lags what is sent by a step or two: at 12.6 mm/s up to 13 um.
        assert!((sent - wanted).abs() < 2e-5, "{i}: {sent} {wanted}");
    }
    for (limit, said) in [
        (
            "limits.displacement_m=0.007",
            "limits.displacement_m = 0.007",
        ),
        (
            "limits.velocity_m_per_s=0.01",
            "limits.velocity_m_per_s = 0.01",
        ),
    ] {
        let t = test(&[limit]);
        let mut connection = connect(loopback(&t));
        let refused = board::commission(
            &mut connection,
            &t,
            (&trajectory, 0),
            &Operator::not_asked(),
            &mut (),
        );
        let refused = refused.unwrap_err().to_string();
        assert!(refused.contains(said), "{refused}");
    }
}

#[test]
fn a_commissioning_chirp_is_recorded_and_reads_back() {
    let t = test(&[]);
    let mut connection = connect(loopback(&t));
    let trajectory = Trajectory::Formula(chirp());
    let played = play(&mut connection, &t, &trajectory);
    let recording = SiRecording::parse("chirp.csv", &played.text).unwrap();
    let command = recording.command_m().unwrap();
    let measured = recording.displacement_m().unwrap();
    assert!(
        (20_000..20_003).contains(&command.len()),
        "{}",
        command.len()
    );
    let peak = command.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
    assert!((peak - 0.01).abs() < 1e-4, "{peak}");
    // The delay of the rig: 4 ms is 8 samples, plus up to one for the converter.
    let error = |shift: usize| -> f64 {
        (shift..command.len())
            .map(|i| (measured[i] - command[i - shift]).powi(2))
            .sum()
    };
    let best = (0..20)
        .min_by(|a, b| error(*a).total_cmp(&error(*b)))
        .unwrap();
    assert!((8..=9).contains(&best), "{best}");
}

#[test]
fn a_board_that_nobody_has_calibrated_runs_nothing_and_one_calibrated_otherwise_runs_no_test_that_names_it()
 {
    let t = test(&[]);
    let Err(Failure::Test(said)) = run_over(&t, Connection::new(loopback(&t), QUICK)) else {
        panic!("armed");
    };
    assert!(
        said.contains("arm: nobody has calibrated the board"),
        "{said}"
    );

    let number = format!(
        "{:08x}",
        loopback(&t).board.hardware.board.wired[0].number()
    );
    let named = test(&[&format!("board.calibration='{number}'")]);
    assert_eq!(
        run_on(&named, loopback(&named)).unwrap().summary.verdict,
        TestVerdict::Completed
    );
    let other = test(&["board.calibration='00c0ffee'"]);
    let Err(Failure::Input(said)) = run_on(&other, loopback(&other)) else {
        panic!("armed");
    };
    assert!(
        said.contains("00c0ffee") && said.contains(&number),
        "{said}"
    );
}

#[test]
fn a_limit_that_the_calibration_cannot_show_is_refused_with_what_it_can() {
    let t = test(&["limits.displacement_m=0.049"]);
    let Err(Failure::Input(said)) = run_on(&t, loopback(&t)) else {
        panic!("armed");
    };
    assert!(
        said.contains("limits.displacement_m = 0.0490") && said.contains("+-42.7 mm"),
        "{said}"
    );
}

#[test]
fn a_piston_that_stands_elsewhere_than_it_is_read_is_not_armed() {
    let t = test(&[]);
    let mut board = loopback(&t);
    let (person, lines) = channel();
    board.incidents.push_back((
        700,
        Box::new(move |_| person.send("14.5".to_owned()).unwrap()),
    ));
    let refused = run_by(&t, connect(board), Operator::by(lines)).unwrap_err();
    let sentence = refused.to_string();
    assert!(
        sentence.contains("said to stand at 14.5 mm") && sentence.contains("nothing has moved"),
        "{sentence}"
    );
    // A script states it beforehand, or has a second transducer.
    let by = |said: Option<&str>| {
        let said = said.map(|text| text.parse().unwrap());
        run_by(
            &t,
            connect(loopback(&t)),
            Operator::script(said, Arc::default()),
        )
    };
    let sentence = by(None).unwrap_err().to_string();
    assert!(sentence.contains("--piston-at"), "{sentence}");
    assert!(by(Some("14.5")).is_err());
    for said in ["0", "none"] {
        let run = by(Some(said)).unwrap();
        assert_eq!(run.summary.verdict, TestVerdict::Completed, "{said}");
    }
}

#[test]
fn a_person_says_go_and_goes_on_after_the_button_has_held_the_test() {
    let t = test(&[]);
    let mut board = loopback(&t);
    let (person, go) = channel();
    let types = |line: &str| -> FaultInjection {
        let (person, line) = (person.clone(), line.to_owned());
        Box::new(move |_| person.send(line.clone()).unwrap())
    };
    let press =
        |down| -> FaultInjection { Box::new(move |b| b.board.hardware.broken.hold_pressed = down) };
    // Steps of the board: nothing is armed before the piston's position is given, nothing starts before Enter, and nothing
    // resumes before Enter or while the button is pressed.
    board.incidents.extend([
        (700, types("")),
        (800, types("0.2")),
        (2900, types("no")),
        (3000, types("")),
        (8000, press(true)),
        (8400, types("")),
        (8800, press(false)),
        (9400, types("")),
    ]);
    let run = run_by(&t, connect(board), Operator::by(go)).unwrap();
    assert_eq!(
        run.summary.verdict,
        TestVerdict::Completed,
        "{}",
        run.summary.sentence()
    );
    assert_eq!(run.summary.steps, 12_000);
    let board = run.summary.board.as_ref().unwrap();
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    // 3000 before the start, the test, and the hold.
    assert!(board.steps_received > 15_700, "{}", board.steps_received);
}

/// The button means the same before a test as during it: nothing is to move.
#[test]
fn the_button_ends_a_test_that_stands_armed_and_says_so() {
    let t = test(&[]);
    let (person, go) = channel();
    let types = |line: &str| -> FaultInjection {
        let (person, line) = (person.clone(), line.to_owned());
        Box::new(move |_| person.send(line.clone()).unwrap())
    };
    let press: FaultInjection = Box::new(|b| b.board.hardware.broken.hold_pressed = true);
    let by_hand = |board| run_by(&t, connect(board), Operator::by(go));
    let mut board = loopback(&t);
    board
        .incidents
        .extend([(800, types("0.2")), (2900, press), (4000, types(""))]);
    let sentence = by_hand(board).unwrap_err().to_string();
    assert!(
        sentence.contains("ended before its start by the board's button"),
        "{sentence}"
    );
}
