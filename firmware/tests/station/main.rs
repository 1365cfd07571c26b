//! Station and service together, as the board runs them, on the host.
#![allow(missing_docs)]

mod any_order;
mod common;
mod coupled;
mod served;
mod single_faults;
mod watch;

use common::{Bench, Spring, bench, config, fresh, pulse, started};
use firmware::sim::{self, CODES};
use firmware::station::Heartbeat;
use link::Calibration;
use link::command::{Channel, Command, CommissioningSignal, SignalShape};
use link::reply::{NotReady, Obstacle, Reply};
use link::telemetry::digest;
use outerloop_core::{
    Config, Design, Event, Fault, GroundMotion, HISTORY, Mode, OuterLoop, Sample, config::Limits,
    flag,
};

fn done(reply: &Reply) -> u32 {
    match reply {
        Reply::Done { tick, .. } => *tick,
        other => panic!("{other:?}"),
    }
}

fn obstacle(reply: Reply) -> Option<Obstacle> {
    match reply {
        Reply::Rejected { obstacle, .. } => obstacle,
        other => panic!("{other:?}"),
    }
}

/// The loop on the PC, fed with the codes that the board reported and the events at the ticks that it answered, has the
/// same bits in every word of every record.
#[test]
fn a_whole_test_is_worked_out_again_from_its_codes_bit_for_bit() {
    let mut b = bench();
    let points = pulse();
    let mut events = Vec::new();
    let configured = done(&b.ask(Command::Configure(config().into())));
    b.upload(&points, 0.01);
    for _ in 0..300 {
        b.step();
    }
    events.push((done(&b.event(Event::Arm)), Event::Arm));
    while b.log.last().unwrap().step.command_m != 0.0 {
        b.step();
    }
    events.push((done(&b.event(Event::Start)), Event::Start));
    for _ in 0..500 {
        b.step();
    }
    events.push((done(&b.event(Event::Hold)), Event::Hold));
    for _ in 0..200 {
        b.step();
    }
    events.push((done(&b.event(Event::Start)), Event::Start));
    b.until(Mode::Finished);
    events.push((done(&b.event(Event::Clear)), Event::Clear));
    for _ in 0..10 {
        b.step();
    }

    let config = config();
    let motion = GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap();
    let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
    let calibration = Calibration::nominal(&CODES);
    let mut moved = 0.0_f32;
    for report in b.log.iter().filter(|r| r.tick >= configured) {
        for (_, event) in events.iter().filter(|(tick, _)| *tick == report.tick) {
            outer.handle(*event).unwrap();
        }
        let mut sample = Sample::new(
            [calibration.displacement.quantity(report.step.displacement)],
            [calibration.force.quantity(report.step.force)],
        );
        sample.chain_open = report.step.flags & flag::CHAIN_OPEN != 0;
        let record = outer.step(&sample, &motion).record;
        assert_eq!(digest(record), report.step.digest, "tick {}", report.tick);
        assert_eq!(
            record.command_m[0].to_bits(),
            report.step.command_m.to_bits()
        );
        moved = moved.max(record.command_m[0].abs());
    }
    assert!(moved > 0.005, "the test moved {moved} m");
    assert_eq!(outer.mode(), Mode::Idle);
}

// proves: command.event, obstacle.not_configured, obstacle.nothing_to_run
// proves: obstacle.fault by stop_pressed
#[test]
fn arming_needs_a_test_and_something_to_run() {
    let mut b = bench();
    b.step();
    assert_eq!(obstacle(b.event(Event::Arm)), Some(Obstacle::NotConfigured));
    done(&b.ask(Command::Configure(config().into())));
    assert_eq!(obstacle(b.event(Event::Arm)), Some(Obstacle::NothingToRun));
    b.upload(&pulse(), 0.01);
    b.hardware.broken.stop_pressed = true;
    b.step();
    let pressed = Some(Obstacle::Fault(Fault::EmergencyStop));
    assert_eq!(obstacle(b.event(Event::Arm)), pressed);
    b.hardware.broken.stop_pressed = false;
    b.step();
    // It may come back.
    assert_eq!(obstacle(b.event(Event::Arm)), pressed);
    b.settle();
    done(&b.ask(Command::Event(Event::Arm)));
}

// proves: command.configure, command.calibrate, command.save, command.signal, command.motion, command.zero
#[test]
fn what_changes_the_test_is_refused_while_it_runs_and_nothing_is_lost() {
    let mut b = bench();
    b.ready(config(), &pulse());
    done(&b.event(Event::Start));
    for command in [
        Command::Configure(config().into()),
        Command::Calibrate(0, Calibration::nominal(&CODES)),
        Command::Save,
        Command::Signal(None),
        Command::Motion {
            points: 10,
            interval_s: 0.01,
            checksum: 0,
        },
        Command::Zero {
            actuator: 0,
            channel: Channel::Force,
            value: 0.0,
        },
    ] {
        let reply = b.ask(command);
        assert!(
            matches!(
                reply,
                Reply::Rejected {
                    mode: Mode::Running,
                    ..
                }
            ),
            "{reply:?}"
        );
    }
    b.until(Mode::Finished);
    done(&b.event(Event::Clear));
    b.until(Mode::Idle);
    // The room that was offered in vain is still there, and so is the ground motion.
    done(&b.ask(Command::Configure(config().into())));
    b.settle();
    done(&b.event(Event::Arm));
}

// proves: command.configure
#[test]
fn a_refused_configuration_says_what_and_changes_nothing() {
    let mut b = bench();
    done(&b.ask(Command::Configure(config().into())));
    let mut bad = config();
    bad.structure.mass_kg[0] = f64::NAN;
    let reply = b.ask(Command::Configure(bad.into()));
    assert!(
        matches!(&reply, Reply::Refused(r) if r.name == "structure.mass_kg"),
        "{reply:?}"
    );
    b.upload(&pulse(), 0.01);
    b.settle();
    done(&b.event(Event::Arm));
}

#[test]
fn a_request_that_comes_twice_is_carried_out_once() {
    let mut b = bench();
    b.ready(config(), &pulse());
    let first = b.event(Event::Start);
    assert_eq!(b.ask_again(Command::Event(Event::Start)), first);
    assert!(matches!(b.event(Event::Start), Reply::Rejected { .. }));
}

/// What happens to a running test: the fault, PERMIT low and the converter where it was, all within `steps`.
fn trips(fault: Fault, steps: usize, harm: impl FnOnce(&mut Bench)) {
    let mut b = bench();
    b.ready(config(), &pulse());
    done(&b.event(Event::Start));
    for _ in 0..200 {
        b.step();
    }
    assert!(b.permit());
    harm(&mut b);
    let mut last = b.code();
    for step in 0.. {
        b.step();
        if !b.permit() {
            break;
        }
        assert!(step < steps, "{fault:?} after {step} steps");
        assert!(b.code().abs_diff(last) < 40, "the converter jumped");
        last = b.code();
    }
    // The last code may have been rounded the other way by the error feedback.
    assert!(
        b.code().abs_diff(last) <= 1,
        "{fault:?}: the converter jumped"
    );
    let held = b.code();
    for _ in 0..100 {
        b.step();
        assert!(!b.permit());
        assert_eq!(b.code(), held, "{fault:?}: the converter holds");
        assert_eq!((b.mode(), b.fault()), (Mode::Tripped, Some(fault)));
    }
    let Reply::Status(status) = b.ask(Command::Status) else {
        panic!("no status");
    };
    assert_eq!(status.trip.map(|t| t.fault), Some(fault));
    let Reply::Record(words) = b.ask(Command::History(HISTORY as u8 - 1)) else {
        panic!("no history");
    };
    assert_eq!(words.len(), outerloop_core::Record::<1>::WORDS);
}

// proves: fault.emergency_stop, fault.adc_rail, fault.stale_sample, fault.deadline_missed, fault.permit_chain, fault.link_lost
// proves: command.status, command.history
#[test]
fn every_fault_drops_the_permission_and_holds_the_converter() {
    trips(Fault::EmergencyStop, 1, |b| {
        b.hardware.broken.stop_pressed = true
    });
    trips(Fault::AdcRail, 1, |b| {
        b.hardware.broken.codes = Some([8190, 4095])
    });
    trips(Fault::AdcRail, 1, |b| {
        b.hardware.broken.codes = Some([4095, 0])
    });
    trips(Fault::StaleSample, 200, |b| {
        let last = b.log.last().unwrap().step;
        b.hardware.broken.codes = Some([last.displacement, last.force]);
    });
    trips(Fault::StaleSample, 30, |b| {
        b.hardware.broken.no_sample = true
    });
    trips(Fault::DeadlineMissed, 1, |b| {
        b.hardware.broken.begins_late = true
    });
    trips(Fault::PermitChain, 8, |b| {
        b.hardware.broken.chain = Some(false)
    });
    // The deceleration ramp included.
    trips(Fault::LinkLost, 1200, |b| b.alive[2] = Heartbeat::Listen);
}

// proves: fault.starved
#[test]
fn a_starved_task_trips_the_test_and_the_watchdog_is_not_fed_any_more() {
    trips(Fault::Starved, 202, |b| b.alive[0] = Heartbeat::Pc);
    let mut b = bench();
    let fed = b.hardware.board.fed;
    for _ in 0..500 {
        b.step();
    }
    let board = &b.hardware.board;
    assert_eq!((board.fed - fed, board.starving), (500, None));
    let fed = board.fed;
    b.alive[1] = Heartbeat::Pc;
    for _ in 0..500 {
        b.step();
    }
    let timeouts = firmware::station::Timeouts::at(2000.0).task_steps;
    assert!((timeouts..timeouts + 3).contains(&(b.hardware.board.fed - fed)));
    assert_eq!(b.hardware.board.starving, Some(Heartbeat::Report));
}

// proves: command.zero, command.identify
#[test]
fn zeroing_moves_the_zero_and_not_the_scale() {
    let mut b = bench();
    b.hardware.broken.codes = Some([5000, 3000]);
    for _ in 0..300 {
        b.step();
    }
    let zero = Command::Zero {
        actuator: 0,
        channel: Channel::Displacement,
        value: 0.001,
    };
    let reply = b.ask(zero);
    assert_eq!(
        reply,
        Reply::Zeroed {
            code: 5000.0,
            spread: 0
        }
    );
    let Reply::Identity(identity) = b.ask(Command::Identify) else {
        panic!("no identity");
    };
    let line = identity.calibration.displacement;
    let reading = line.quantity(5000);
    assert!((reading - 0.001).abs() < 1e-7);
    assert_eq!(
        line.per_code,
        Calibration::nominal(&CODES).displacement.per_code
    );
}

/// Plays the signal that is set, from idle to its end by itself.
fn commissioned_for_three_seconds(b: &mut Bench) {
    for _ in 0..300 {
        b.step();
    }
    done(&b.event(Event::Arm));
    while b.log.last().unwrap().step.command_m != 0.0 {
        b.step();
    }
    done(&b.event(Event::Start));
    b.until(Mode::Commissioning);
    let steps = b.until(Mode::Finished);
    assert!((5998..=6003).contains(&steps), "{steps}");
}

// proves: command.signal
#[test]
fn a_commissioning_signal_runs_and_ends_by_itself() {
    let mut b = bench();
    done(&b.ask(Command::Configure(config().into())));
    done(&b.ask(Command::Signal(Some(CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Sine { frequency_hz: 2.0 },
        amplitude_m: 0.01,
        seconds: 3.0,
    }))));
    commissioned_for_three_seconds(&mut b);
    let largest = b.log.iter().rev().take(6000).map(|r| r.step.command_m);
    let largest = largest.fold(0.0_f32, |a, x| a.max(x.abs()));
    assert!((largest - 0.01).abs() < 1e-4, "{largest}");
}

#[test]
fn points_that_were_sent_are_played_once_named_so_and_are_no_ground_motion_after_that() {
    let mut b = bench();
    done(&b.ask(Command::Configure(config().into())));
    let signal = CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Points,
        amplitude_m: 0.01,
        seconds: 3.0,
    };
    // Nothing was sent, and then too much.
    for points in [None, Some([0.0_f32, 0.011, 0.0, 0.0])] {
        if let Some(points) = points {
            b.upload(&points, 1.0);
        }
        let reply = b.ask(Command::Signal(Some(signal)));
        assert!(
            matches!(&reply, Reply::Refused(r) if r.name == "signal.points_m"),
            "{reply:?}"
        );
    }
    b.upload(&[0.0, 0.01, -0.005, 0.0], 1.0);
    done(&b.ask(Command::Signal(Some(signal))));
    commissioned_for_three_seconds(&mut b);
    let played: Vec<f32> = b
        .log
        .iter()
        .rev()
        .take(6000)
        .map(|r| r.step.command_m)
        .collect();
    let largest = played.iter().copied().fold(0.0_f32, f32::max);
    let least = played.iter().copied().fold(0.0_f32, f32::min);
    assert!(
        (largest - 0.01).abs() < 1e-5 && (least + 0.005).abs() < 1e-5,
        "{largest} {least}"
    );
    done(&b.event(Event::Clear));
    done(&b.ask(Command::Signal(None)));
    let reply = b.event(Event::Arm);
    assert!(matches!(reply, Reply::Rejected { .. }), "{reply:?}");
}

#[test]
fn a_signal_of_points_plays_no_others_that_are_sent_behind_it() {
    let mut b = bench();
    done(&b.ask(Command::Configure(config().into())));
    b.upload(&[0.0, 0.002, -0.002, 0.0], 1.0);
    done(&b.ask(Command::Signal(Some(CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Points,
        amplitude_m: 0.002,
        seconds: 3.0,
    }))));
    // A ground motion, m/s^2, is no way, m.
    b.upload(&pulse(), 0.01);
    b.settle();
    done(&b.event(Event::Arm));
    b.until(Mode::Armed);
    done(&b.event(Event::Start));
    b.step();
    assert_eq!(b.mode(), Mode::Running, "it is played as what it is");
}

// proves: limit.displacement_m, limit.velocity_m_per_s, limit.force_n, limit.tracking_m, limit.stale_steps
#[test]
fn a_test_without_a_limit_or_beyond_what_the_calibration_shows_is_refused_by_the_limits_name() {
    let mut b = bench();
    type LeaveOut = fn(&mut Limits);
    let leave_out: [(&str, LeaveOut); 5] = [
        ("limits.displacement_m", |l| l.displacement_m = None),
        ("limits.velocity_m_per_s", |l| l.velocity_m_per_s = None),
        ("limits.force_n", |l| l.force_n = None),
        ("limits.tracking_m", |l| l.tracking_m = None),
        ("limits.stale_steps", |l| l.stale_steps = None),
    ];
    for (name, leave_out) in leave_out {
        let mut open = config();
        leave_out(&mut open.limits);
        let reply = b.ask(Command::Configure(open.into()));
        assert!(
            matches!(&reply, Reply::Refused(r) if r.name == name && r.value.is_nan()),
            "{reply:?}"
        );
    }
    // What was inside the range when the test came is not when another calibration has come since.
    done(&b.ask(Command::Configure(config().into())));
    b.upload(&pulse(), 0.01);
    let narrow = Calibration::over(0.02, 1e4, &CODES);
    done(&b.ask(Command::Calibrate(0, narrow)));
    let reply = b.event(Event::Arm);
    assert!(
        matches!(&reply, Reply::Refused(r) if r.name == "limits.displacement_m"),
        "{reply:?}"
    );
    assert_eq!(b.board.mode(), Mode::Idle);
}

/// What is there and can never act, by a slip of the unit for example, is none.
#[test]
fn a_limit_or_a_correction_that_a_slip_of_the_unit_has_made_is_refused_by_its_name() {
    type Slip = fn(&mut Config);
    let slips: [(&str, Slip); 6] = [
        ("limits.disagree_m", |c| c.limits.disagree_m = Some(1.0)),
        ("limits.force_stands_m", |c| {
            c.limits.force_stands_m = Some(2.0)
        }),
        ("limits.energy_trip", |c| c.limits.energy_trip = Some(300.0)),
        ("loop.approach_m_per_s", |c| c.timing.approach_m_per_s = 2.0),
        ("rig.command_offset_m", |c| {
            c.rig.command_offset_m = [3e-3].into_iter().collect()
        }),
        ("rig.displacement_offset_m", |c| {
            c.rig.displacement_offset_m = [-3e-3].into_iter().collect()
        }),
    ];
    let mut b = bench();
    for (name, slip) in slips {
        let mut wrong = config();
        slip(&mut wrong);
        let reply = b.ask(Command::Configure(wrong.into()));
        assert!(
            matches!(&reply, Reply::Refused(r) if r.name == name),
            "{name}: {reply:?}"
        );
    }
}

// proves: obstacle.not_calibrated, command.calibrate
#[test]
fn a_board_that_nobody_has_calibrated_is_not_armed_and_says_so() {
    let mut b = fresh();
    let status = |b: &mut Bench| match b.ask(Command::Status) {
        Reply::Status(status) => status,
        other => panic!("{other:?}"),
    };
    assert!(!status(&mut b).calibrated);
    done(&b.ask(Command::Configure(config().into())));
    b.upload(&pulse(), 0.01);
    for command in [
        Command::Event(Event::Arm),
        Command::Zero {
            actuator: 0,
            channel: Channel::Force,
            value: 0.0,
        },
    ] {
        assert_eq!(obstacle(b.ask(command)), Some(Obstacle::NotCalibrated));
    }
    // What the board went by takes a calibration back, wherever it comes from.
    for (calibration, made) in [
        (Calibration::nominal(&CODES), true),
        (Calibration::placeholder(&CODES), false),
        (Calibration::nominal(&CODES), true),
    ] {
        done(&b.ask(Command::Calibrate(0, calibration)));
        assert_eq!(status(&mut b).calibrated, made);
    }
    b.settle();
    done(&b.event(Event::Arm));
}

// proves: command.save
#[test]
fn a_calibration_is_saved_without_a_test_and_a_test_beside_it() {
    let mut b = fresh();
    assert_eq!(
        obstacle(b.ask(Command::Save)),
        Some(Obstacle::NotCalibrated)
    );
    done(&b.ask(Command::Calibrate(0, Calibration::nominal(&CODES))));
    done(&b.ask(Command::Save));
    assert_eq!(b.saved, [None, Some(firmware::station::CALIBRATION_BYTES)]);
    done(&b.ask(Command::Configure(config().into())));
    done(&b.ask(Command::Save));
    assert!(b.saved[0].is_some());
}

/// Else the next start would have the old one again.
#[test]
fn a_calibration_that_is_taken_back_is_saved_as_that() {
    let mut b = fresh();
    done(&b.ask(Command::Calibrate(0, Calibration::nominal(&CODES))));
    done(&b.ask(Command::Save));
    b.saved = [None; 2];
    done(&b.ask(Command::Calibrate(0, Calibration::placeholder(&CODES))));
    done(&b.ask(Command::Save));
    assert_eq!(b.saved, [None, Some(firmware::station::CALIBRATION_BYTES)]);
}

#[test]
fn the_button_holds_a_running_test_once_and_the_pc_goes_on() {
    let mut b = bench();
    b.ready(config(), &pulse());
    done(&b.event(Event::Start));
    for _ in 0..100 {
        b.step();
    }
    b.hardware.broken.hold_pressed = true;
    b.step();
    assert_eq!(b.mode(), Mode::Holding);
    is_held(&b.event(Event::Start));
    b.step();
    assert_eq!(b.mode(), Mode::Holding);
    b.hardware.broken.hold_pressed = false;
    b.step();
    done(&b.event(Event::Start));
    for _ in 0..20 {
        b.step();
        assert_ne!(b.mode(), Mode::Holding);
    }
}

fn is_held(reply: &Reply) {
    assert!(
        matches!(reply, Reply::Refused(r) if r.is(NotReady::Held)),
        "{reply:?}"
    );
}

// proves: obstacle.held by hold_pressed
/// Whoever presses it has something against a motion, also against one that has not begun.
#[test]
fn the_button_ends_what_is_armed_and_nothing_is_armed_or_started_while_it_is_pressed() {
    let mut b = bench();
    b.ready(config(), &pulse());
    assert!(b.permit());
    b.hardware.broken.hold_pressed = true;
    b.step();
    b.step();
    assert_eq!((b.mode(), b.permit()), (Mode::Idle, false));
    b.settle();
    is_held(&b.event(Event::Arm));
    b.hardware.broken.hold_pressed = false;
    b.step();
    done(&b.event(Event::Arm));
    b.until(Mode::Armed);
    // It goes down in the step in whose end the order is taken.
    b.hardware.broken.hold_pressed = true;
    is_held(&b.event(Event::Start));
    b.until(Mode::Idle);
    assert!(!b.permit());
}

/// There is no test to go on with: what would go on is the ground motion.
#[test]
fn the_button_in_the_first_step_of_a_commissioning_signal_ends_it() {
    let mut b = bench();
    b.ready(config(), &pulse());
    done(&b.event(Event::Stop));
    let signal = CommissioningSignal {
        actuator: 0,
        shape: SignalShape::Constant,
        amplitude_m: 0.001,
        seconds: 5.0,
    };
    done(&b.ask(Command::Signal(Some(signal))));
    b.settle();
    done(&b.event(Event::Arm));
    b.until(Mode::Armed);
    done(&b.event(Event::Start));
    b.hardware.broken.hold_pressed = true;
    b.step();
    b.step();
    assert_eq!(b.mode(), Mode::Finished);
}

// proves: fault.permit_chain, obstacle.fault by chain
#[test]
fn a_welded_contact_stands_against_arming() {
    let mut b = bench();
    done(&b.ask(Command::Configure(config().into())));
    b.upload(&pulse(), 0.01);
    b.hardware.broken.chain = Some(true);
    for _ in 0..300 {
        b.step();
    }
    assert_eq!(
        obstacle(b.event(Event::Arm)),
        Some(Obstacle::Fault(Fault::PermitChain))
    );
}

// proves: obstacle.crystal by crystal_ok
// proves: obstacle.converters by converters_ok
#[test]
fn what_the_start_has_found_wrong_stands_against_arming() {
    for (crystal_ok, converters_ok, against) in [
        (true, true, None),
        (false, true, Some(Obstacle::Crystal)),
        (true, false, Some(Obstacle::Converters)),
    ] {
        let mut found = sim::Bench::<Spring>::well("sim");
        found.crystal_ok = crystal_ok;
        found.converters_ok = converters_ok;
        let mut b = started(found);
        done(&b.ask(Command::Calibrate(0, Calibration::nominal(&CODES))));
        done(&b.ask(Command::Configure(config().into())));
        b.upload(&pulse(), 0.01);
        b.settle();
        let reply = b.event(Event::Arm);
        match against {
            None => assert!(done(&reply) > 0),
            Some(_) => assert_eq!(obstacle(reply), against),
        }
    }
}
