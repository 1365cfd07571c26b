//! Three actuators on one board: station, service, link and the PC's side, on this machine.

use experiment::Experiment;
use experiment::bench::Played;
use experiment::failure::Failure;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::judged::JudgedRun;
use experiment::summary::TestVerdict;
use experiment::trace::Trace;
use firmware::sim::{CODES, Wire};
use host_tests::loopback::{FaultInjection, Loopback};
use link::Calibration;
use link::channel::number_of;
use link::command::{CommissioningSignal, SignalShape};
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_cli::board::{
    self, BoardBench, BoardConnection, Connection, Operator, Port, Timeouts, Trajectory,
};
use outerloop_cli::serve::serve_on_board;
use outerloop_core::{Fault, Mode};
use plant::Rig;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

const QUICK: Timeouts = Timeouts {
    answer: Duration::from_millis(50),
    stop: Duration::from_millis(40),
    silence: Duration::from_millis(200),
};

/// The strong part of the example with three storeys, with a peak that converters of 12 bits resolve well.
fn test(overrides: &[&str]) -> TestFile {
    let text = include_str!("../../../examples/three-storey.toml");
    let strong = ["excitation.duration_s=6", "excitation.peak_response_mm=40"];
    let overrides: Vec<String> = strong
        .iter()
        .chain(overrides)
        .map(|s| (*s).into())
        .collect();
    TestFile::parse(text, "three-storey.toml", Path::new(""), &overrides).unwrap()
}

/// Each actuator has its own ranges; some signs are reversed.
fn wired() -> [Calibration; 3] {
    let [first, mut second, mut third] =
        [(0.1, 1e5), (0.2, 1.2e5), (0.15, 8e4)].map(|(m, n)| Calibration::over(m, n, &CODES));
    second.command.per_code *= -1.0;
    second.force.zero_code += 20.0;
    third.displacement.per_code *= -1.0;
    [first, second, third]
}

/// A connection with each actuator calibrated as it is wired.
fn connect(loopback: Loopback<3>) -> Connection<Loopback<3>> {
    let mut connection = Connection::new(loopback, QUICK);
    for (actuator, calibration) in (0..).zip(wired()) {
        board::calibrate_one(&mut connection, actuator, calibration).unwrap();
    }
    connection
}

/// A chirp of 3 mm.
fn chirp() -> Trajectory {
    Trajectory::Formula(CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Chirp {
            from_hz: 0.5,
            to_hz: 4.0,
        },
        amplitude_m: 0.003,
        seconds: 6.0,
    })
}

/// Moves `actuator` alone.
fn commission(
    t: &TestFile,
    connection: &mut Connection<Loopback<3>>,
    actuator: usize,
) -> Result<Played, Failure> {
    let trajectory = chirp();
    let alone = (&trajectory, actuator);
    board::commission(connection, t, alone, &Operator::not_asked(), &mut ())
}

fn loopback(t: &TestFile) -> Loopback<3> {
    let storeys = &t.config.structure.stiffness_n_per_m;
    let rig = Rig::new(&t.plant, storeys, t.config.timing.rate_hz, 1).unwrap();
    let mut loopback = Loopback::new(rig);
    loopback.board.hardware.board.wired = wired();
    loopback
}

fn run(t: &TestFile, loopback: Loopback<3>, calibrated: usize) -> Result<JudgedRun, Failure> {
    let mut connection = Connection::new(loopback, QUICK);
    for (actuator, calibration) in (0..).zip(wired()).take(calibrated) {
        board::calibrate_one(&mut connection, actuator, calibration).unwrap();
    }
    let experiment = Experiment::new(t.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let plan = PlannedMotion::of(&experiment, &ideal);
    let bench = BoardBench::new(connection, plan, Operator::not_asked())
        .expecting(t.board.calibration.clone());
    let method = t.config.compensation.kind;
    experiment.run_on(&bench, method, &ideal, true, None::<Trace>)
}

#[test]
fn a_whole_test_has_the_bits_of_the_loop_on_the_pc_and_ends_as_on_the_rig_without_a_board() {
    let number = format!("{:08x}", number_of(&wired()));
    let t = test(&[&format!("board.calibration='{number}'")]);
    let on_board = run(&t, loopback(&t), 3).unwrap();
    let board = on_board.summary.board.as_ref().unwrap();
    assert_eq!(on_board.summary.verdict, TestVerdict::Completed);
    assert_eq!((board.steps_lost, board.steps_different), (0, 0));
    assert!(board.steps_received > 12_000);

    let experiment = Experiment::new(t.clone(), &near_fault(), None).unwrap();
    let ideal = experiment.ideal().unwrap();
    let method = t.config.compensation.kind;
    let plain = experiment
        .run(method, &ideal, 1, false, None::<Trace>)
        .unwrap();
    let (board, plain) = (on_board.summary.eps_rms, plain.summary.eps_rms);
    println!("eps_rms {board:.4} through converters of 12 bits, {plain:.4} without");
    assert!(board < plain + 0.01, "{board} {plain}");
}

#[test]
fn a_step_that_is_lost_on_its_way_makes_no_error_at_any_floor() {
    let t = test(&[]);
    let mut lossy = loopback(&t);
    let lose: FaultInjection<3> = Box::new(|b| b.drop_frames = 1);
    lossy.incidents.push_back((6000, lose));
    let [whole, lossy] = [loopback(&t), lossy].map(|board| run(&t, board, 3).unwrap().summary);
    assert!(lossy.board.as_ref().unwrap().steps_lost > 0);
    assert_eq!(lossy.verdict, TestVerdict::Completed);
    // The error is that of the steps before it.
    let (eps, of_all) = (lossy.eps_rms, whole.eps_rms);
    assert!(eps > 0.0 && eps < 1.5 * of_all, "{eps} {of_all}");
    let floors = &lossy.eps_rms_by_floor;
    assert!(floors.iter().all(|e| e.is_finite()), "{floors:?}");
}

#[test]
fn permission_falls_when_every_actuator_stands() {
    // Ends in mid-motion: at some of them an upper floor is much faster than the first, which then stops long before it.
    for duration_s in [2.7, 2.9, 3.1, 3.3, 3.5, 3.7] {
        falls_when_all_stand(duration_s);
    }
}

fn falls_when_all_stand(duration_s: f64) {
    let duration = format!("excitation.duration_s={duration_s}");
    // The ramp is so slow that a floor at rest at its start stops long before the others.
    let t = test(&[
        &duration,
        "excitation.peak_response_mm=10",
        "loop.hold_deceleration_m_per_s2=0.5",
        "limits.displacement_m=0.08",
        "limits.force_n=50000",
    ]);
    let mut board = loopback(&t);
    // The codes from the end of the test until PERMIT falls.
    let seen = Arc::new(Mutex::new(Vec::new()));
    for step in 0..20_000 {
        let seen = Arc::clone(&seen);
        let look = move |l: &mut Loopback<3>| {
            let board = &l.board.hardware.board;
            if board.permit && l.board.mode() == Mode::Finished {
                seen.lock().unwrap().push(board.code);
            }
        };
        board.incidents.push_back((step, Box::new(look)));
    }
    let summary = run(&t, board, 3).unwrap().summary;
    let (ended, why) = (summary.verdict, summary.sentence());
    assert_eq!(ended, TestVerdict::Completed, "{why} {:?}", summary.trip);
    let seen = seen.lock().unwrap();
    let moved = seen[0] != *seen.last().unwrap();
    let last = &seen[seen.len() - 20..];
    println!(
        "{duration_s} s: {} steps from the end to PERMIT low",
        seen.len()
    );
    // The command may be rounded up or down.
    let stands = |code: &[u16; 3]| (0..3).all(|a| code[a].abs_diff(last[0][a]) <= 1);
    assert!(moved && last.iter().all(stands), "{last:?}");
}

#[test]
fn each_actuators_channels_are_calibrated_before_anything_is_armed() {
    // Small enough for the range of an uncalibrated board.
    let t = test(&["excitation.peak_response_mm=5"]);
    let Err(Failure::Test(said)) = run(&t, loopback(&t), 2) else {
        panic!("armed");
    };
    assert!(said.contains("nobody has calibrated the board"), "{said}");
}

#[test]
fn a_rail_on_any_actuator_trips_the_test_and_a_converter_out_of_its_range_too() {
    let t = test(&[]);
    for actuator in 0..3 {
        for codes in [[8190, 4095], [4095, 3]] {
            let mut broken = loopback(&t);
            let happen = move |l: &mut Loopback<3>| {
                (
                    l.board.hardware.broken.actuator,
                    l.board.hardware.broken.codes,
                ) = (actuator, Some(codes));
            };
            broken.incidents.push_back((8000, Box::new(happen)));
            let run = run(&t, broken, 3).unwrap();
            let board = run.summary.board.as_ref().unwrap();
            assert_eq!(board.trip, Some(Fault::AdcRail), "actuator {actuator}");
            assert_eq!(board.steps_different, 0, "actuator {actuator}");
        }
    }
}

#[test]
fn the_last_actuators_force_is_watched_and_named() {
    let t = test(&["limits.force_n=20e3"]);
    let mut pushed = loopback(&t);
    let line = wired()[2].force;
    let code = (30e3 / line.per_code + line.zero_code) as u16;
    let happen = move |l: &mut Loopback<3>| {
        let broken = &mut l.board.hardware.broken;
        (broken.actuator, broken.codes) = (2, Some([4095, code]));
    };
    pushed.incidents.push_back((8000, Box::new(happen)));
    let run = run(&t, pushed, 3).unwrap();
    let trip = run.summary.trip_detail.unwrap();
    assert_eq!((trip.fault, trip.axis), (Fault::Force, 2));
    assert!((trip.value / 30e3 - 1.0).abs() < 0.01, "{}", trip.value);
    assert_eq!(run.summary.board.as_ref().unwrap().steps_different, 0);
}

#[test]
fn a_test_with_fewer_storeys_in_the_laboratory_than_actuators_is_refused() {
    let t = test(&["structure.physical_storeys=1"]);
    let storeys = test(&[]);
    let Err(Failure::Input(said)) = run(&t, loopback(&storeys), 3) else {
        panic!("armed");
    };
    assert!(
        said.contains("1 storeys in the laboratory") && said.contains("the board has 3"),
        "{said}"
    );
}

/// Stiffness of the example's shear frame at floor `j` for a motion of floor `i`, N/m.
fn declared(t: &TestFile, j: usize, i: usize) -> f64 {
    let k = |storey: usize| {
        let all = &t.config.structure.stiffness_n_per_m;
        all.get(storey).copied().unwrap_or(0.0)
    };
    match j.abs_diff(i) {
        0 => k(i) + k(i + 1),
        1 => -k(i.max(j)),
        _ => 0.0,
    }
}

#[test]
fn each_actuator_is_commissioned_alone_and_finds_its_column_of_the_stiffness() {
    let t = test(&["compensation.delay_ms=4"]);
    let mut connection = connect(loopback(&t));
    for actuator in 0..3 {
        let played = commission(&t, &mut connection, actuator).unwrap();
        assert_eq!((&played.early, &played.suspicion), (&None, &None));
        // Two codes of the coarsest converter.
        assert!((played.peak_m - 0.003).abs() < 1e-4, "{}", played.peak_m);
        for (j, found) in played.stiffness_n_per_m.iter().enumerate() {
            let wanted = declared(&t, j, actuator);
            let Some(found) = found else {
                assert_eq!(wanted, 0.0, "force {j} of actuator {actuator}");
                continue;
            };
            assert!(
                (found / wanted - 1.0).abs() < 0.02,
                "{actuator} {j}: {found}"
            );
        }
        let found = diagnosis::identify(&played.recording().unwrap()).unwrap();
        println!("actuator {}: {found:?}", actuator + 1);
        // 4 ms, plus up to half a millisecond for the steps of converter and command.
        assert!(
            (found.delay_ms + found.lag_ms - 4.25).abs() < 0.5,
            "{found:?}"
        );
        assert!((found.gain - 1.0).abs() < 0.01, "{found:?}");
    }
    // The board is idle again, and all is as it was.
    let status = board::status(&mut connection).unwrap();
    assert_eq!((status.mode, status.permit), (Mode::Idle, false));
}

#[test]
fn wires_that_two_actuators_have_exchanged_are_named_before_anything_else_moves() {
    let t = test(&["compensation.delay_ms=4"]);
    for (wire, exchanged, moved, said) in [
        (
            Wire::Command,
            [0, 1],
            0,
            "actuator 2 was to stand and moved",
        ),
        (
            Wire::Displacement,
            [1, 2],
            2,
            "actuator 2 was to stand and moved",
        ),
        (Wire::Force, [0, 1], 0, "that of actuator 2 with 1.59"),
        (Wire::Force, [1, 2], 1, "that of actuator 3 with 1.59"),
        (Wire::Force, [0, 2], 2, "that of actuator 1 with 0.79"),
    ] {
        let mut wrong = loopback(&t);
        // The approach to zero starts at zero: nothing moves before the signal.
        wrong.board.hardware.broken.exchanged = Some((wire, exchanged));
        // All with the same ranges, as laboratories buy them.
        let same = Calibration::over(0.1, 1e5, &CODES);
        wrong.board.hardware.board.wired = [same; 3];
        let mut connection = Connection::new(wrong, QUICK);
        board::calibrate(&mut connection, same).unwrap();
        let played = commission(&t, &mut connection, moved).unwrap();
        let suspicion = played.suspicion.unwrap_or_default();
        println!("{wire:?} {exchanged:?}: {:?}; {suspicion}", played.early);
        assert!(
            suspicion.contains(said),
            "{wire:?} {exchanged:?}: {suspicion}"
        );
        assert!(suspicion.contains("look exchanged"), "{suspicion}");
        // An actuator that moves without a command is stopped; a load cell moves nothing.
        let trips = wire != Wire::Force;
        assert_eq!(played.early.is_some(), trips, "{wire:?}");
        if trips {
            let early = played.early.unwrap();
            assert!(
                early.contains("tracking of actuator") || early.contains("stale_sample"),
                "{early}"
            );
            assert!(played.peak_m < 0.002, "{}", played.peak_m);
            assert!(!board::status(&mut connection).unwrap().permit);
        }
    }
}

#[test]
fn a_channel_with_the_wrong_polarity_is_named_for_what_it_is() {
    let t = test(&["compensation.delay_ms=4"]);
    for (channel, said) in [
        ("command", "moves against its command"),
        ("force", "the force of actuator 2 falls by 1.59"),
    ] {
        let mut connection = connect(loopback(&t));
        let mut wrong = wired()[1];
        match channel {
            "command" => wrong.command.per_code *= -1.0,
            _ => wrong.force.per_code *= -1.0,
        }
        board::calibrate_one(&mut connection, 1, wrong).unwrap();
        let played = commission(&t, &mut connection, 1).unwrap();
        let suspicion = played.suspicion.unwrap_or_default();
        println!("{channel}: {:?}; {suspicion}", played.early);
        assert!(suspicion.contains(said), "{channel}: {suspicion}");
    }
}

#[test]
fn a_wire_that_breaks_at_another_actuator_stops_the_one_that_moves_and_is_named() {
    let t = test(&["compensation.delay_ms=4"]);
    for (codes, which) in [
        ([2, 4095], "the displacement of actuator 3"),
        ([4095, 8190], "the force of actuator 3"),
    ] {
        let mut broken = loopback(&t);
        let happen = move |l: &mut Loopback<3>| {
            let broken = &mut l.board.hardware.broken;
            (broken.actuator, broken.codes) = (2, Some(codes));
        };
        broken.incidents.push_back((6000, Box::new(happen)));
        let mut connection = connect(broken);
        let played = commission(&t, &mut connection, 0).unwrap();
        let early = played.early.unwrap();
        assert!(
            early.contains("adc_rail") && early.contains(which),
            "{early}"
        );
        assert!(played.steps > 1000 && played.suspicion.is_none());
        assert!(!board::status(&mut connection).unwrap().permit);
        // A person must clear it before anything continues.
        let Err(Failure::Test(said)) = commission(&t, &mut connection, 1) else {
            panic!("it went on");
        };
        assert!(said.contains("stands tripped on adc_rail"), "{said}");
    }
}

#[test]
fn commissioning_looks_at_the_calibration_that_the_test_names_and_at_the_actuators_that_there_are()
{
    let number = format!("{:08x}", number_of(&wired()));
    let right = test(&[
        "compensation.delay_ms=4",
        &format!("board.calibration='{number}'"),
    ]);
    let mut connection = connect(loopback(&right));
    assert!(commission(&right, &mut connection, 0).is_ok());
    for (wrong, said) in [
        (test(&["board.calibration='00c0ffee'"]), number.as_str()),
        (test(&["board.converter_bits=16"]), "12 bits"),
        (test(&["structure.physical_storeys=1"]), "the board has 3"),
    ] {
        let Err(Failure::Input(refused)) = commission(&wrong, &mut connection, 0) else {
            panic!("accepted");
        };
        assert!(refused.contains(said), "{refused}");
    }
    let Err(Failure::Input(refused)) = commission(&right, &mut connection, 3) else {
        panic!("accepted");
    };
    assert!(refused.contains("accepted are 1 to 3"), "{refused}");
}

#[test]
fn a_dead_output_of_any_actuator_is_told_from_a_valve_that_does_not_follow() {
    let t = test(&["limits.tracking_m=0.01"]);
    for actuator in 0..3 {
        let mut dead = loopback(&t);
        let happen = move |l: &mut Loopback<3>| {
            l.board.hardware.board.dead_output = Some(actuator);
        };
        dead.incidents.push_back((8000, Box::new(happen)));
        let run = run(&t, dead, 3).unwrap();
        let board = run.summary.board.as_ref().unwrap();
        let further = board.further.as_ref().unwrap();
        let said = further.sentence(board.trip).unwrap();
        println!("{:?}: {said}", board.trip);
        assert!(
            said.starts_with(&format!("The command of actuator {}", actuator + 1))
                && said.contains("look at the output converter"),
            "{said}"
        );
        for (other, off_m) in further.commands_off_m.iter().enumerate() {
            let off_m = off_m.unwrap();
            assert_eq!(off_m > 3e-4, other == actuator, "{other}: {off_m}");
        }
    }
}

/// A frame of three storeys, all in the laboratory, with actuators that are 2 ms late.
fn served(pace: &str) -> TestFile {
    test(&[
        &format!("serve.pace={pace}"),
        "loop.substeps=20",
        "loop.solve_substeps=12",
        "loop.late_limit_steps=60000",
        "loop.approach_m_per_s=0.2",
        "limits.displacement_m=0.03",
        "limits.force_n=60e3",
        "limits.velocity_m_per_s=1",
        "limits.tracking_m=0.02",
        "plant.actuator.delay_ms=2",
    ])
}

#[test]
fn targets_for_three_actuators_are_gone_to_and_answered_with_three_forces() {
    for pace in ["stop_and_go", "continuous"] {
        let t = served(pace);
        let port: Box<dyn Port> = Box::new(loopback(&t));
        let mut connection: BoardConnection = Connection::new(port, QUICK);
        for (actuator, calibration) in (0..).zip(wired()) {
            board::calibrate_one(&mut connection, actuator, calibration).unwrap();
        }
        let mut rig =
            serve_on_board(&t, connection, Operator::not_asked(), false, true, None).unwrap();
        rig.begin().unwrap();
        let (mut worst_n, mut last) = (0.0_f64, [0.0; 3]);
        for i in 1..=60 {
            let swing = |a: f64, w: f64| a * (w * f64::from(i)).sin();
            let target_m = [swing(0.004, 0.11), swing(0.007, 0.13), swing(0.01, 0.1)];
            let reached = rig.go_to(&target_m).unwrap();
            assert_eq!(reached.force_n.len(), 3);
            // In continuous mode an answer is for the position of the target before.
            let at_m = if pace == "continuous" { last } else { target_m };
            last = target_m;
            for (j, n) in reached.force_n.iter().enumerate().filter(|_| i > 2) {
                let model: f64 = (0..3).map(|k| declared(&t, j, k) * at_m[k]).sum();
                worst_n = worst_n.max((n - model).abs());
            }
        }
        rig.end().unwrap();
        let account = rig.on_board().unwrap();
        println!("{pace}: forces within {worst_n:.0} N of the model's; {account:?}");
        assert_eq!((account.steps_lost, account.steps_different), (0, 0));
        assert!(!rig.permit());
        // Codes of 24, 49 and 37 um at 1.6 kN/mm; in continuous mode also the 2 ms of delay and the damping that compensates it.
        let room_n = if pace == "stop_and_go" { 150.0 } else { 2500.0 };
        assert!(worst_n < room_n, "{pace}: {worst_n}");
    }
}
