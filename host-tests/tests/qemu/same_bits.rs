//! The image in QEMU does what core does on this machine, bit for bit, whatever happens in a test.

use host_tests::qemu::bench::{self, emulated, first_difference, here, rig, shaking};
use host_tests::qemu::image::image;
use host_tests::qemu::machine::{Clock, Test};
use host_tests::{Scenario, table1};
use outerloop_core::config::{ActuatorTimes, Filter};
use outerloop_core::{Config, Event, Fault, Method, Mode};
use std::cell::RefCell;
use std::collections::BTreeSet;

/// The whole pipeline at work: noise, the two-stage filter, Eq 20, every interlock.
fn noisy(mut scenario: Scenario) -> Scenario {
    let config = &mut scenario.config;
    config.estimation.kind = Filter::Kalman;
    config.estimation.delay_ms = 4.0.into();
    config.estimation.lag_ms = 0.5.into();
    config.estimation.displacement_noise_m = 2e-5;
    config.timing.approach_m_per_s = 0.1;
    config.limits.displacement_m = Some(0.2);
    config.limits.increment_m = Some(2e-3);
    config.limits.velocity_m_per_s = Some(3.0);
    config.limits.force_n = Some(1e5);
    config.limits.tracking_m = Some(0.05);
    config.limits.energy_trip = Some(10.0);
    config.limits.stale_steps = Some(5);
    scenario.sensors = "displacement_noise_mm = 0.02\nforce_noise_n = 10.0\nbits = 16".into();
    scenario
}

/// An operator who holds and resumes, and later clears the board's fault and starts again.
fn busy(tick: u32, mode: Mode) -> (Option<Event>, Option<Fault>) {
    let event = match (tick, mode) {
        (3000, _) => Some(Event::Hold),
        (3500, _) => Some(Event::Start),
        (200.., Mode::Idle) => Some(Event::Arm),
        (_, Mode::Armed) => Some(Event::Start),
        (7100, Mode::Tripped) => Some(Event::Clear),
        (11_000, _) => Some(Event::Stop),
        _ => None,
    };
    (event, (tick == 7000).then_some(Fault::AdcRail))
}

fn same<const N: usize>(
    scenario: &Scenario,
    ticks: u32,
    script: bench::Script<'_>,
) -> Option<Vec<u32>> {
    let image = image("qemu", "qemu")?;
    let shaking = shaking(8.0);
    let test = Test::new(&scenario.config, &shaking);
    let (here, hash, _) = here::<N>(&test, ticks, script, rig(scenario, 1)).unwrap();
    let (there, summary) =
        emulated::<N>(&image, Clock::Free, &test, ticks, script, rig(scenario, 1)).unwrap();
    assert_eq!(
        first_difference(&here, &there),
        None,
        "control period and word of the record"
    );
    assert_eq!((summary.hash, summary.steps), (hash, ticks));
    println!("{N} DOF, {ticks} control periods: hash {hash:016x} in QEMU and here");
    let mut modes: Vec<u32> = here.iter().map(|words| words[2] & 0xf).collect();
    modes.dedup();
    Some(modes)
}

const MODES: [Mode; 12] = [
    Mode::Idle,
    Mode::Armed,
    Mode::Running,
    Mode::Holding,
    Mode::Returning,
    Mode::Running,
    Mode::Tripped,
    Mode::Idle,
    Mode::Approaching,
    Mode::Armed,
    Mode::Running,
    Mode::Finished,
];

#[test]
fn one_degree_of_freedom() {
    let scenario = noisy(Scenario::delayed(table1(), 4.0));
    if let Some(modes) = same::<1>(&scenario, 12_000, &busy) {
        assert_eq!(modes, MODES.map(|s| s as u32));
    }
}

/// Events are drawn in every mode that a session reaches, and board faults between them.
// proves: mode.idle.*, mode.armed.*, mode.running.*, mode.holding.*, mode.finished.*, mode.tripped.*, mode.approaching.*
// proves: mode.stopping.*
// proves: fault.adc_rail, fault.emergency_stop, fault.deadline_missed, fault.link_lost, fault.disagree
// proves: fault.force_stands
#[test]
fn every_event_in_every_mode_and_every_fault_of_a_board() {
    const BOARDS: [Fault; 8] = [
        Fault::AdcRail,
        Fault::EmergencyStop,
        Fault::DeadlineMissed,
        Fault::LinkLost,
        Fault::PermitChain,
        Fault::Output,
        Fault::Disagree,
        Fault::ForceStands,
    ];
    let mut scenario = noisy(Scenario::delayed(table1(), 4.0));
    // The method is faded in after a hold, and the approach is slow.
    scenario.config.compensation.kind = Method::Tangent;
    scenario.config.timing.approach_m_per_s = 0.01;
    let seen = RefCell::new((BTreeSet::new(), BTreeSet::new()));
    let random = |tick: u32, mode: Mode| {
        let draw = (tick.wrapping_add(1).wrapping_mul(0x9e37_79b9) ^ (tick << 7))
            .wrapping_mul(0x85eb_ca6b)
            >> 8;
        let event = Event::ALL[draw as usize % Event::ALL.len()];
        // Events that end a test are rarer than those that continue it; short modes get events more often.
        let out = matches!(
            event,
            Event::Stop | Event::Finish | Event::Fault | Event::MinorFault
        );
        let one_in = match mode {
            Mode::Stopping => 5,
            Mode::Resuming => 11,
            Mode::Returning => 23,
            Mode::Armed if out => 101,
            Mode::Approaching | Mode::Running | Mode::Holding if out => 331,
            _ => 41,
        };
        let asked = (draw / 7).is_multiple_of(one_in);
        // In idle a fault blocks arming for 200 steps: there are fewer there, or hardly any test would start.
        let drawn = draw % 997 == 3 && (mode != Mode::Idle || (draw / 997).is_multiple_of(11));
        let fault = drawn.then(|| BOARDS[draw as usize / 997 % BOARDS.len()]);
        let mut seen = seen.borrow_mut();
        if asked {
            seen.0.insert((mode as u8, event as u8));
        }
        if let Some(fault) = fault.filter(|_| mode == Mode::Running) {
            seen.1.insert(fault.code());
        }
        (asked.then_some(event), fault)
    };
    if same::<1>(&scenario, 200_000, &random).is_none() {
        return;
    }
    let (pairs, faults) = seen.into_inner();
    // Some pairs of these modes are too rare to be drawn.
    let short = [Mode::Commissioning, Mode::Returning, Mode::Resuming];
    let missing = Mode::ALL
        .into_iter()
        .filter(|mode| !short.contains(mode))
        .flat_map(|mode| Event::ALL.map(|event| (mode, event)))
        .filter(|(mode, event)| !pairs.contains(&(*mode as u8, *event as u8)));
    assert_eq!(missing.collect::<Vec<_>>(), []);
    let missing = BOARDS.iter().filter(|f| !faults.contains(&f.code()));
    // These two are drawn at least in other modes.
    let missing = missing.filter(|f| !matches!(f, Fault::PermitChain | Fault::Output));
    assert_eq!(
        missing.collect::<Vec<_>>(),
        [&Fault::AdcRail; 0],
        "in a running test"
    );
}

#[test]
fn three_degrees_of_freedom() {
    let mut scenario = noisy(Scenario::delayed(
        Config::shear_frame([1000.0; 3], [797.3e3; 3], [0.02; 3]),
        4.0,
    ));
    // Each actuator has its own delay and lag, known to the loop.
    scenario.actuator =
        "kind = 'lag_delay'\ndelay_ms = [4.0, 6.0, 9.0]\nlag_ms = [0.5, 1.0, 0.7]".into();
    let times = |ms| ActuatorTimes::each(ms).unwrap();
    scenario.config.compensation.delay_ms = times(&[4.5, 7.0, 9.7]);
    scenario.config.estimation.delay_ms = times(&[4.0, 6.0, 9.0]);
    scenario.config.estimation.lag_ms = times(&[0.5, 1.0, 0.7]);
    if let Some(modes) = same::<3>(&scenario, 12_000, &busy) {
        assert_eq!(modes, MODES.map(|s| s as u32));
    }
}

/// The designs are computed in f64 on both sides, on the target in software; the test runs to the end of the record.
#[test]
fn a_whole_test_to_its_end() {
    let scenario = Scenario::delayed(table1(), 4.0);
    if let Some(modes) = same::<1>(&scenario, 17_000, &bench::plain) {
        let to_the_end = [Mode::Idle, Mode::Armed, Mode::Running, Mode::Finished];
        assert_eq!(modes, to_the_end.map(|s| s as u32));
    }
}

#[test]
fn a_refusal_has_the_same_words() {
    let Some(image) = image("qemu", "qemu") else {
        return;
    };
    let mut scenario = Scenario::delayed(table1(), 4.0);
    scenario.config.structure.damping_ratio[0] = -7.5;
    let shaking = shaking(1.0);
    let test = Test::new(&scenario.config, &shaking);
    let good = Scenario::delayed(table1(), 4.0);
    let here = here::<1>(&test, 1, &bench::plain, rig(&good, 1))
        .unwrap_err()
        .to_string();
    let there = emulated::<1>(&image, Clock::Free, &test, 1, &bench::plain, rig(&good, 1));
    assert_eq!(there.unwrap_err().to_string(), here);
    assert!(here.contains("structure.damping_ratio = -7.5"), "{here}");
}
