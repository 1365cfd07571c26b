//! What trips a test: sensors, limits, the link. Each leaves PERMIT low within a stated time, the command held, the reason
//! readable, and no step lost.

use crate::desk::{Bench, Desk, PERIOD_NS, codes, config, fine};
use emu::{Contact, InjectedFault, LoggedEvent, PlannedFault};
use host_tests::loopback::command_of_version;
use link::VERSION;
use link::command::Command;
use link::reply::{NotReady, Obstacle, Reply};
use outerloop_core::{Config, Event, Fault, Method, Mode};

/// A running test, with a fault 0.6 s after PERMIT and with other limits.
pub(crate) fn begun(fault: Option<InjectedFault>, change: impl Fn(&mut Config)) -> Desk {
    begun_with(fault, 1200, change)
}

/// The same with the fault `after_steps` steps after PERMIT.
fn begun_with(
    fault: Option<InjectedFault>,
    after_steps: u64,
    change: impl Fn(&mut Config),
) -> Desk {
    let plan = fault.map(|fault| PlannedFault { after_steps, fault });
    let bench = Bench {
        plan,
        ..Bench::default()
    };
    let mut desk = configured(bench, change);
    desk.arm_and_start();
    desk
}

/// A board with a changed test, after some time in idle.
pub(crate) fn configured(bench: Bench, change: impl Fn(&mut Config)) -> Desk {
    let mut desk = Desk::with(bench);
    desk.load();
    let mut config = config();
    change(&mut config);
    desk.order(Command::Configure(config.into()));
    for _ in 0..300 {
        desk.step();
    }
    desk
}

/// What runs trips on `reason`; checks what follows. Returns the time from the fault to PERMIT low, ns.
pub(crate) fn trips(desk: &mut Desk, reason: Fault) -> Option<u64> {
    desk.until(Mode::Tripped);
    for _ in 0..100 {
        desk.step();
    }
    let status = desk.status();
    assert_eq!(status.trip.map(|t| t.fault), Some(reason));
    assert!(!status.permit);
    assert_eq!((status.dropped_steps, status.timing.overruns), (0, 0));
    let seen = desk.log().seen;
    let low = seen
        .iter()
        .rposition(|(_, s)| *s == LoggedEvent::Permit(false))
        .unwrap();
    let code = |s: &(u64, LoggedEvent)| match s.1 {
        LoggedEvent::Command(code) => Some(code),
        _ => None,
    };
    let held = seen[..low].iter().rev().find_map(code).unwrap();
    let after: Vec<u16> = seen[low..].iter().filter_map(code).collect();
    assert!(
        after.iter().all(|&c| c == held),
        "{reason:?}: the command stood at {held} and moves after PERMIT is low: {after:?}"
    );
    let codes: Vec<u16> = seen.iter().filter_map(code).collect();
    assert!(
        codes.windows(2).all(|w| w[0].abs_diff(w[1]) <= 12 * fine()),
        "the command jumps"
    );
    desk.order(Command::Event(Event::Clear));
    assert_eq!(desk.status().mode, Mode::Idle);
    let at = seen
        .iter()
        .find(|(_, s)| *s == LoggedEvent::Fault)
        .map(|s| s.0);
    let after = at.map(|at| seen[low].0 - at);
    if let Some(after) = after {
        println!("{reason:?}: PERMIT low {} us after it", after / 1000);
    }
    after
}

// proves: fault.adc_rail by SensorAtRail
#[test]
fn a_broken_sensor_wire() {
    let mut desk = begun(Some(InjectedFault::SensorAtRail), |_| {});
    let after = trips(&mut desk, Fault::AdcRail).unwrap();
    assert!(after <= PERIOD_NS, "{after} ns");
    desk.assert_nothing_lost();
}

// proves: fault.stale_sample, limit.stale_steps by FrozenSensor
#[test]
fn a_sensor_that_stands_still() {
    let mut desk = begun(Some(InjectedFault::FrozenSensor), |_| {});
    let after = trips(&mut desk, Fault::StaleSample).unwrap();
    // As many as the test allows, and more while the target itself hardly moves.
    let stale_steps = u64::from(config().limits.stale_steps.unwrap());
    assert!(after >= stale_steps * PERIOD_NS, "{after} ns");
    assert!(after <= 3 * stale_steps * PERIOD_NS, "{after} ns");
    desk.assert_nothing_lost();
}

// proves: fault.force, limit.force_n by NoiseBurst
#[test]
fn a_burst_of_noise_beyond_the_limit_of_the_force() {
    let mut desk = begun(Some(InjectedFault::NoiseBurst), |c| {
        c.limits.force_n = Some(4500.0)
    });
    let after = trips(&mut desk, Fault::Force).unwrap();
    assert!(after <= 2 * PERIOD_NS, "{after} ns");
    desk.assert_nothing_lost();
}

// proves: fault.increment, fault.velocity, fault.displacement, fault.force, fault.tracking, fault.energy_ratio
// proves: limit.increment_m, limit.velocity_m_per_s, limit.displacement_m, limit.force_n, limit.tracking_m, limit.energy_trip
#[test]
fn each_limit() {
    let limits: [(Fault, fn(&mut Config)); 6] = [
        (Fault::Increment, |c| {
            (c.limits.increment_m, c.limits.velocity_m_per_s) = (Some(2e-5), None);
        }),
        (Fault::Velocity, |c| c.limits.velocity_m_per_s = Some(0.04)),
        (Fault::Displacement, |c| {
            c.limits.displacement_m = Some(0.003)
        }),
        (Fault::Force, |c| c.limits.force_n = Some(400.0)),
        (Fault::Tracking, |c| c.limits.tracking_m = Some(0.0001)),
        // The rig is 3 ms late, and nothing removes the energy that this adds.
        (Fault::EnergyRatio, |c| {
            c.compensation.kind = Method::None;
            c.limits.energy_trip = Some(0.02);
        }),
    ];
    for (reason, limit) in limits {
        let mut desk = begun(None, limit);
        trips(&mut desk, reason);
        desk.assert_nothing_lost();
    }
}

// proves: fault.non_finite by LostMotion
#[test]
fn a_ground_motion_whose_memory_reads_as_ones() {
    let mut desk = begun(Some(InjectedFault::LostMotion), |_| {});
    let after = trips(&mut desk, Fault::NonFinite).unwrap();
    // At the next target of the equation of motion.
    let periods = u64::from(config().timing.substeps);
    assert!(after <= (periods + 1) * PERIOD_NS, "{after} ns");
    // No NaN outlives the test: the same motion, sent again, runs to its end.
    desk.load();
    desk.order(Command::Event(Event::Arm));
    desk.until(Mode::Armed);
    desk.order(Command::Event(Event::Start));
    desk.until(Mode::Finished);
    assert_eq!(desk.status().trip, None);
}

// proves: fault.permit_chain by Chain(Contact::Broken)
#[test]
fn a_relay_that_opens_by_itself() {
    let mut desk = begun(Some(InjectedFault::Chain(Contact::Broken)), |_| {});
    let after = trips(&mut desk, Fault::PermitChain).unwrap();
    // A contact that was closed has 3 ms.
    assert!(after <= 8 * PERIOD_NS, "{after} ns");
    desk.assert_nothing_lost();
}

// proves: fault.permit_chain, obstacle.fault by Chain(Contact::Welded)
#[test]
fn a_relay_that_stays_closed_stands_against_the_next_arming() {
    let mut desk = begun(Some(InjectedFault::Chain(Contact::Welded)), |_| {});
    desk.until(Mode::Finished);
    desk.order(Command::Event(Event::Clear));
    // Earlier telemetry is still on its way.
    desk.until(Mode::Idle);
    for _ in 0..500 {
        desk.step();
    }
    let reply = desk.ask(Command::Event(Event::Arm));
    let welded = Some(Obstacle::Fault(Fault::PermitChain));
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == welded),
        "{reply:?}"
    );
}

// proves: obstacle.no_energy_trip
#[test]
fn a_test_that_the_board_integrates_is_not_armed_without_a_limit_of_its_energy_error() {
    let mut desk = configured(Bench::default(), |c| c.limits.energy_trip = None);
    let reply = desk.ask(Command::Event(Event::Arm));
    assert!(
        matches!(&reply, Reply::Refused(r) if r.is(NotReady::NoEnergyTrip)),
        "{reply:?}"
    );
}

/// Codes of the output while PERMIT was high, on the way to a mode. The rig sinks some millimetres below zero before it is
/// armed: the approach raises the codes.
fn shown_with_permit(fault: Option<InjectedFault>, to: Mode) -> Vec<u16> {
    let bench = Bench {
        plan: fault.map(|fault| PlannedFault {
            after_steps: 0,
            fault,
        }),
        sinks_m_per_s: 0.01,
        ..Bench::default()
    };
    // 2 mm in the time that a contact is given to close: 80 codes of 12 bits.
    let mut desk = configured(bench, |c| c.timing.approach_m_per_s = 0.02);
    desk.order(Command::Event(Event::Arm));
    desk.until(to);
    let log = desk.log();
    let high = log.permitted.iter().position(|p| *p);
    let high = high.expect("PERMIT was high");
    let shown = log.pin.iter().zip(&log.permitted).skip(high);
    let shown = shown.take_while(|(_, permitted)| **permitted);
    shown.filter_map(|(code, _)| *code).collect()
}

#[test]
fn nothing_approaches_before_the_contact_behind_permit_has_closed() {
    let raised = |shown: &[u16]| {
        let most = shown.iter().max().expect("codes");
        most - shown[0]
    };
    // It never closes: PERMIT is withdrawn 0.1 s later.
    let open = InjectedFault::Chain(Contact::Broken);
    let never = shown_with_permit(Some(open), Mode::Tripped);
    assert!((195..=210).contains(&never.len()), "{}", never.len());
    // It closes after 10 ms, and the last code before that is the twentieth.
    let later = shown_with_permit(None, Mode::Armed);
    let before = &later[..18];
    println!(
        "the command has gone up by {} codes behind an open contact, {} before it closes, {} to zero",
        raised(&never),
        raised(before),
        raised(&later)
    );
    // The output alternates between two codes.
    assert!(raised(&never) <= 2 * fine(), "{never:?}");
    assert!(raised(before) <= 2 * fine(), "{before:?}");
    assert!(raised(&later) > 50 * fine(), "it does not approach");
}

// proves: obstacle.held by Button
#[test]
fn the_blue_button_holds_the_test() {
    let mut desk = begun(Some(InjectedFault::Button), |_| {});
    desk.until(Mode::Holding);
    // The test cannot resume while it is pressed.
    let reply = desk.ask(Command::Event(Event::Start));
    assert!(
        matches!(&reply, Reply::Refused(r) if r.is(NotReady::Held)),
        "{reply:?}"
    );
    for _ in 0..700 {
        desk.step();
    }
    assert_eq!(desk.step().mode(), Some(Mode::Holding));
    desk.order(Command::Event(Event::Start));
    desk.until(Mode::Finished);
    assert_eq!(desk.status().trip, None);
}

// proves: command.configure, obstacle.not_calibrated
#[test]
fn a_test_without_limits_and_a_board_without_calibration_are_refused() {
    let mut desk = Desk::new(None);
    let mut open = config();
    open.limits = Default::default();
    let Reply::Refused(refused) = desk.ask(Command::Configure(open.into())) else {
        panic!("a test without limits is accepted");
    };
    assert_eq!(refused.name.as_str(), "limits.displacement_m");
    desk.order(Command::Configure(config().into()));
    let reply = desk.ask(Command::Event(Event::Arm));
    let nobody = Some(Obstacle::NotCalibrated);
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == nobody),
        "{reply:?}"
    );
}

// proves: fault.link_lost by LinkCut
#[test]
fn a_cut_line_ends_the_test_by_itself_and_the_reason_is_there_when_it_is_mended() {
    // The link is lost some 400 ms after the cut, when the piston is at its fastest.
    let mut desk = begun_with(Some(InjectedFault::LinkCut(2000)), 1450, |_| {});
    let after = trips(&mut desk, Fault::LinkLost).unwrap();
    println!("PERMIT low {} ms after the cut", after / 1_000_000);
    // The timeout of half a second, and the deceleration ramp.
    assert!(after <= 1_400 * PERIOD_NS, "{after} ns");
    let log = desk.log();
    let low = log
        .permitted
        .iter()
        .rposition(|p| *p)
        .expect("PERMIT was high");
    let line = link::Calibration::nominal(&codes()).command;
    let shown = log.pin[low - 100..low].iter().flatten();
    let sent_m: Vec<f64> = shown.map(|code| line.quantity(*code).into()).collect();
    let step_m: Vec<f64> = sent_m.windows(2).map(|w| (w[1] - w[0]).abs()).collect();
    let [fast, slow] = [&step_m[..20], &step_m[step_m.len() - 20..]].map(|s| s.iter().sum::<f64>());
    println!(
        "of the last 50 ms before PERMIT fell it went {fast} m in the first ten and {slow} m in the last"
    );
    // It slows down from 80 mm/s and more to a standstill, instead of stopping at once; codes of 24 um.
    assert!(fast > 20.0 * 40e-6, "{step_m:?}");
    assert!(
        slow < 0.5 * fast && step_m[step_m.len() - 1] <= 2.5e-5,
        "{step_m:?}"
    );
    // The link may be lost again at once: after it is back, it blocks arming for a while.
    let reply = desk.ask(Command::Event(Event::Arm));
    let lost = Some(Obstacle::Fault(Fault::LinkLost));
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == lost),
        "{reply:?}"
    );
}

#[test]
fn garbage_on_the_line_changes_nothing() {
    let mut desk = begun(None, |_| {});
    let before = desk.status();
    let mut word = 1_u32;
    for _ in 0..400 {
        let garbage: Vec<u8> = (0..40)
            .map(|_| {
                word = word.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (word >> 24) as u8
            })
            .collect();
        desk.wire.send(&garbage);
        desk.step();
    }
    desk.until(Mode::Finished);
    let after = desk.status();
    assert_eq!(after.trip, None);
    assert!(
        after.link.bad() > before.link.bad() + 10,
        "{:?}",
        after.link
    );
    assert_eq!((after.dropped_steps, after.timing.overruns), (0, 0));
    desk.assert_nothing_lost();
}

#[test]
fn a_program_of_another_link_is_not_listened_to_and_counted() {
    let mut desk = Desk::new(None);
    desk.load();
    let before = desk.status().link;
    for version in [VERSION - 1, VERSION + 1] {
        let arm = command_of_version(version, &Command::Event(Event::Arm));
        desk.wire.send(&arm);
        for _ in 0..50 {
            assert_eq!(desk.step().mode(), Some(Mode::Idle), "version {version}");
        }
    }
    let status = desk.status();
    assert_eq!(status.link.other_version, before.other_version + 2);
    assert!(!status.permit);
    desk.order(Command::Event(Event::Arm));
}

// proves: command.configure, command.event
#[test]
fn a_configuration_with_a_number_that_is_none_is_refused_and_changes_nothing() {
    let mut desk = Desk::new(None);
    desk.load();
    for value in [f64::NAN, f64::INFINITY, -1.0] {
        let mut bad = config();
        bad.limits.displacement_m = Some(value);
        let Reply::Refused(refused) = desk.ask(Command::Configure(bad.into())) else {
            panic!("{value} is accepted");
        };
        assert_eq!(refused.name.as_str(), "limits.displacement_m");
    }
    let status = desk.status();
    assert!(status.configured && status.trip.is_none());
    desk.order(Command::Event(Event::Arm));
    desk.until(Mode::Armed);
}
