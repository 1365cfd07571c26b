//! What the flashed image does with each command that no other scenario sends, and with the faults that need a test of
//! their own.

use crate::desk::{Desk, TABLE_1, codes, config};
use crate::limits_and_link::begun;
use emu::InjectedFault;
use experiment::Experiment;
use experiment::files::near_fault::near_fault;
use experiment::files::test::TestFile;
use experiment::trace::TestObserver;
use experiment::watch::{Place, TestWatch};
use link::command::{Channel, CommissioningSignal, SignalShape};
use link::frame::checksum;
use link::reply::{Obstacle, Reply};
use link::{Calibration, Command};
use outerloop_core::watch::State;
use outerloop_core::{Config, Event, Fault, HISTORY, Mode, Pace, Record};
use std::path::Path;

fn obstacle(desk: &mut Desk, command: Command) -> Option<Obstacle> {
    match desk.ask(command) {
        Reply::Rejected { obstacle, .. } => obstacle,
        other => panic!("{other:?}"),
    }
}

// proves: command.identify, command.zero, command.calibrate, obstacle.not_calibrated
#[test]
fn a_calibration_is_shown_zeroed_and_wanted_before_it_is_saved() {
    let mut desk = Desk::new(None);
    assert_eq!(
        obstacle(&mut desk, Command::Save),
        Some(Obstacle::NotCalibrated)
    );
    desk.order(Command::Calibrate(0, Calibration::nominal(&codes())));
    for _ in 0..300 {
        desk.step();
    }
    let zero = Command::Zero {
        actuator: 0,
        channel: Channel::Force,
        value: 500.0,
    };
    let reply = desk.ask(zero);
    let Reply::Zeroed { code, .. } = reply else {
        panic!("{reply:?}");
    };
    let Reply::Identity(identity) = desk.ask(Command::Identify) else {
        panic!("no identity");
    };
    let line = identity.calibration.force;
    let reading = (code - line.zero_code) * line.per_code;
    assert!((reading - 500.0).abs() < 0.1, "{reading} N");
    assert_eq!(line.per_code, Calibration::nominal(&codes()).force.per_code);
}

// proves: obstacle.not_configured, obstacle.nothing_to_run, command.signal
#[test]
fn arming_wants_a_test_and_something_to_run() {
    let mut desk = Desk::new(None);
    desk.calibrate();
    for _ in 0..300 {
        desk.step();
    }
    let signal = CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Sine { frequency_hz: 5.0 },
        amplitude_m: 0.002,
        seconds: 1.5,
    };
    let arm = || Command::Event(Event::Arm);
    let not_configured = Some(Obstacle::NotConfigured);
    assert_eq!(obstacle(&mut desk, arm()), not_configured);
    assert_eq!(
        obstacle(&mut desk, Command::Signal(Some(signal))),
        not_configured
    );
    desk.order(Command::Configure(config().into()));
    assert_eq!(obstacle(&mut desk, arm()), Some(Obstacle::NothingToRun));
    desk.order(Command::Signal(Some(signal)));
    desk.order(Command::Signal(None));
    assert_eq!(obstacle(&mut desk, arm()), Some(Obstacle::NothingToRun));
    desk.order(Command::Signal(Some(signal)));
    // The board had lost the PC; this blocks arming for a while.
    let armed = (0..1000).any(|_| matches!(desk.ask(arm()), Reply::Done { .. }));
    assert!(armed);
    desk.until(Mode::Armed);
    while desk.step().command_m != 0.0 {}
    desk.order(Command::Event(Event::Start));
    desk.until(Mode::Commissioning);
    let mut largest = 0.0_f32;
    while let Some(Mode::Commissioning) = desk.step().mode() {
        let (_, last) = desk.steps.last().unwrap();
        largest = largest.max(last.command_m.abs());
    }
    assert!((largest - 0.002).abs() < 1e-5, "{largest} m");
    desk.until(Mode::Finished);
}

// proves: command.pace, command.target, command.history, fault.target_late
#[test]
fn targets_that_stop_coming_trip_the_test_and_the_steps_before_are_kept() {
    let mut desk = Desk::new(None);
    desk.load();
    let mut config = config();
    (config.timing.substeps, config.timing.solve_substeps) = (20, 12);
    config.timing.late_limit_steps = 200;
    desk.order(Command::Configure(config.into()));
    desk.order(Command::Pace(Some(Pace::Continuous)));
    for _ in 0..300 {
        desk.step();
    }
    desk.order(Command::Event(Event::Arm));
    desk.until(Mode::Armed);
    while desk.step().command_m != 0.0 {}
    let target = |m: f32| Command::Target([m].into_iter().collect());
    desk.order(target(0.0));
    desk.order(Command::Event(Event::Start));
    for i in 1..20_u16 {
        desk.order(target(1e-4 * f32::from(i)));
        for _ in 0..20 {
            desk.step();
        }
    }
    let reached = desk.step();
    assert_eq!(reached.mode(), Some(Mode::Running));
    assert!(reached.command_m > 1e-3, "{} m", reached.command_m);
    desk.until(Mode::Tripped);
    let status = desk.status();
    assert_eq!(status.trip.map(|t| t.fault), Some(Fault::TargetLate));
    assert!(!status.permit);
    let reply = desk.ask(Command::History(HISTORY as u8 - 1));
    let Reply::Record(words) = reply else {
        panic!("{reply:?}");
    };
    assert_eq!(words.len(), Record::<1>::WORDS);
    assert_eq!(words[0], status.trip.unwrap().tick);
}

// proves: command.motion, command.points, command.status
#[test]
fn a_ground_motion_with_a_gap_or_another_sum_is_not_loaded() {
    let mut desk = Desk::new(None);
    desk.calibrate();
    desk.order(Command::Configure(config().into()));
    let points = [0.5_f32; 100];
    let sum = checksum(points.iter().flat_map(|p| p.to_le_bytes()));
    let motion = |checksum| Command::Motion {
        points: points.len() as u32,
        interval_s: 0.01,
        checksum,
    };
    let part = |first: usize, to: usize| Command::Points {
        first: first as u32,
        points: points[first..to].iter().copied().collect(),
    };
    let loaded = |desk: &mut Desk| match desk.ask(Command::Status) {
        Reply::Status(status) => status.points,
        other => panic!("{other:?}"),
    };
    desk.order(motion(sum));
    desk.order(part(0, 40));
    assert_eq!(desk.ask(part(50, 100)), Reply::Expected(40));
    desk.order(part(40, 100));
    assert_eq!(loaded(&mut desk), 100);
    desk.order(motion(sum ^ 1));
    assert_eq!(desk.ask(part(0, 100)), Reply::WrongSum { received: sum });
    assert_eq!(loaded(&mut desk), 0);
    assert_eq!(
        obstacle(&mut desk, Command::Event(Event::Arm)),
        Some(Obstacle::NothingToRun)
    );
}

/// A test with other limits, with a fault 0.6 s after PERMIT, trips on `reason`, with PERMIT low.
fn trips(fault: InjectedFault, reason: Fault, change: impl Fn(&mut Config)) {
    let mut desk = begun(Some(fault), change);
    desk.until(Mode::Tripped);
    let status = desk.status();
    assert_eq!(status.trip.map(|t| t.fault), Some(reason));
    assert!(!status.permit);
    desk.assert_nothing_lost();
    let course = desk.course();
    let after_us = (course.permit_low_ns - course.fault_ns) / 1000;
    println!("{reason:?}, {fault:?}: PERMIT low {after_us} us after it");
}

// proves: fault.disagree, limit.disagree_m by DeadSecondSensor
#[test]
fn a_second_displacement_that_is_dead_trips() {
    trips(InjectedFault::DeadSecondSensor, Fault::Disagree, |c| {
        c.limits.disagree_m = Some(1e-3);
    });
}

// proves: fault.force_stands, limit.force_stands_m by DeadForce
#[test]
fn a_load_cell_that_is_dead_trips() {
    trips(InjectedFault::DeadForce, Fault::ForceStands, |c| {
        c.limits.force_stands_m = Some(2e-3);
    });
}

// proves: fault.stale_sample, limit.frozen_m by StandingSensor
#[test]
fn a_transducer_that_stands_in_its_noise_trips_by_the_motion_that_it_may_hide() {
    trips(InjectedFault::StandingSensor, Fault::StaleSample, |c| {
        c.limits.frozen_m = Some(3e-4);
        c.limits.tracking_m = Some(0.04);
    });
}

// proves: fault.reading by Slip
#[test]
fn a_reading_beyond_the_stroke_trips() {
    trips(InjectedFault::Slip { um: 26_000 }, Fault::Reading, |c| {
        // The command stays inside the stroke; the reading does not.
        c.limits.displacement_m = Some(0.033);
        c.limits.tracking_m = Some(0.033);
    });
}

// proves: command.watch
#[test]
fn what_the_rig_watch_cannot_be_told_is_refused_in_a_sentence() {
    let mut desk = Desk::new(None);
    let test = TestFile::parse(TABLE_1, "test.toml", Path::new(""), &[]).unwrap();
    let experiment = Experiment::new(test.clone(), &near_fault(), None).unwrap();
    let place = Place {
        ideal: &experiment.ideal().unwrap(),
        first_hz: experiment.natural_frequencies_hz()[0],
        seconds: experiment.seconds,
    };
    let mut watch = TestWatch::of(&test, &place).unwrap().unwrap();
    let told = watch.watches_the_loop().unwrap().remove(0);
    let told = || told.clone();
    assert_eq!(
        obstacle(&mut desk, Command::Watch(0, told())),
        Some(Obstacle::NotConfigured)
    );
    desk.order(Command::Configure(config().into()));
    let mut slow = told();
    slow.declared.rate_hz = 1000.0;
    for (actuator, told, says) in [
        (1, told(), "actuator = 2 "),
        (0, slow, "the rate of the test in force"),
    ] {
        let Reply::Refused(refused) = desk.ask(Command::Watch(actuator, told)) else {
            panic!("accepted");
        };
        assert!(refused.to_string().contains(says), "{refused}");
    }
    assert_eq!(desk.status().watch, None);
    desk.order(Command::Watch(0, told()));
    let said = desk.status().watch.expect("it is watched");
    assert_eq!((said.state, said.blocks), (State::Sound, 0));
}
