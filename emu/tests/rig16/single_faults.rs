//! Single faults, each before arming and in a running test at several phases: until PERMIT falls the piston moves no more than
//! 2 mm beyond the plan. The rig has a second displacement and stated limits; how far it goes without either is printed.
//!
//! Faults that no signal of this board shows are not included; the independent interlock must act on them: both displacements
//! wrong together (their common bracket), a specimen that is not what was declared (bounded by the stroke and the energy),
//! PERMIT's relay welded shut while the command moves (the valve's own power).

use crate::desk::{Bench, Desk, STIFFNESS_N_PER_M, codes, config};
use emu::{Contact, InjectedFault, Log, LoggedEvent, PlannedFault, ResetLine as Line};
use link::limits::CalibratedRange;
use link::reply::{Obstacle, Reply};
use link::{Calibration, Command};
use outerloop_cli::board::limits::PlannedMotion;
use outerloop_core::config::Limits;
use outerloop_core::{Config, Event, Fault, Mode};

/// Largest motion allowed beyond the plan, m.
pub const BEYOND_M: f64 = 2e-3;

/// An actuator: its delay, ms, and its valve's velocity limit, m/s.
#[derive(Clone, Copy)]
pub struct Actuator {
    delay_ms: f64,
    valve_m_per_s: f64,
}

/// The usual one: the delay of Table 1, and the valve of a large ram.
pub const USUAL: Actuator = Actuator {
    delay_ms: 3.0,
    valve_m_per_s: 0.75,
};

/// One that responds in the next period, as fast as its valve.
const AT_ONCE: Actuator = Actuator {
    delay_ms: 0.5,
    valve_m_per_s: 1.0,
};

/// Faults are listed by their short names.
use InjectedFault::*;

static FAULTS: [InjectedFault; 68] = [
    OutputDips,
    StuckData { high: false },
    DeadSensor,
    DeadForce,
    Chain(Contact::Broken),
    DeadOutput,
    SensorAtRail,
    FrozenSensor,
    StandingSensor,
    NoiseBurst,
    EmergencyStop,
    LinkCut(2500),
    Reset,
    Button,
    DeadValve,
    InputDips,
    StuckData { high: true },
    LateWord,
    FrozenForce,
    StandingForce,
    ForceAtRail,
    ReversedForce,
    Slip { um: 3000 },
    Slip { um: -3000 },
    Slip { um: 1500 },
    ReadingGain { percent: 50 },
    ReadingGain { percent: 150 },
    DeadSecondSensor,
    Chain(Contact::Unread),
    NoKnownVoltage,
    ReadBackOpen,
    KnownVoltageFlickers,
    ReadBackFlickers,
    SecondSensorFlickers,
    Gain { percent: 150 },
    Gain { percent: 50 },
    Gain { percent: 0 },
    LateBy(20),
    LateBy(100),
    SlowTimer,
    FastTimer,
    Runaway { up: true },
    Runaway { up: false },
    CommandOpen,
    ForceFlickers,
    SensorFlickers,
    InputScale { percent: 92 },
    InputScale { percent: 108 },
    InputStands,
    Chain(Contact::Chatters),
    PortWithoutClock,
    ForceContact { open: 10, of: 15 },
    ForceContact { open: 40, of: 60 },
    HummingForce { codes: 29 },
    SlowInput,
    OpenData,
    ResetLine(Line::InputBus),
    ResetLine(Line::OutputBus),
    ResetLine(Line::SamplingTimer),
    ResetLine(Line::OutputTimer),
    // The firmware's own drills: panic, fault of the processor, stack, starved task, hang, late step, clock, supply.
    Drill(1),
    Drill(2),
    Drill(3),
    Drill(4),
    Drill(5),
    Drill(6),
    Drill(7),
    Drill(8),
];

/// A load cell whose sign reverses in a running test looks like a specimen that breaks: it is left to the limits of energy, force
/// and stroke (docs/hazards.md).
const LIKE_A_BREAK: InjectedFault = ReversedForce;

/// Faults that stay on the plan's path but fall behind it: a test held by a person; a link lost for long, which ends on the same
/// ramp; a program that hangs and commands nothing more; a port that does not drop PERMIT while the relay falls; a loop that
/// advances only with a sample, so that the test runs slower.
const BEHIND: [InjectedFault; 7] = [
    Button,
    LinkCut(2500),
    Drill(5),
    KnownVoltageFlickers,
    PortWithoutClock,
    SlowInput,
    ResetLine(Line::SamplingTimer),
];

/// Steps recorded of the plan, and of a test with a fault; both allow for a lost link.
const PLANNED_STEPS: usize = 3600;
const SEEN_STEPS: usize = 2600;

/// Control steps in a millisecond.
const STEPS_PER_MS: f64 = 2.0;

/// Control steps from `Arm` to a test that may start, at most.
const LONGEST_APPROACH: usize = 4000;

/// Longest time with PERMIT before a test starts, control steps.
const BEFORE_THE_START: usize = 150;

/// Control steps with PERMIT at which a fault comes: while the target rises, near its peak, and after it.
pub const PHASES: [u64; 3] = [1250, 1400, 1700];

/// Limits stated in the test.
pub fn stated() -> Limits {
    Limits {
        tracking_m: Some(1.2e-3),
        disagree_m: Some(1e-3),
        force_stands_m: Some(2e-3),
        ..config().limits
    }
}

/// Limits that `outerloop run` derives from a plan if none are stated: the second displacement is not compared.
pub fn worked_out(plan: &[f64]) -> Limits {
    let timing = config().timing;
    let peak_m = plan.iter().fold(0.0_f64, |most, m| most.max(m.abs()));
    let steps_m = plan.windows(2).map(|w| (w[1] - w[0]).abs());
    let motion = PlannedMotion {
        displacement_m: peak_m,
        velocity_m_per_s: steps_m.fold(0.0, f64::max) * timing.rate_hz,
        force_n: peak_m * STIFFNESS_N_PER_M,
        noise_m: 0.0,
        noise_n: 0.0,
        delay_s: USUAL.delay_ms * 1e-3,
        approach_m_per_s: timing.approach_m_per_s,
        rate_hz: timing.rate_hz,
        force_stands_m: Some(0.25 * peak_m),
    };
    let lines = Calibration::nominal(&codes());
    let shown = CalibratedRange::by_all([&lines], &codes());
    motion.limits(&Limits::default(), &shown)
}

pub fn single(
    actuator: Actuator,
    fault: Option<InjectedFault>,
    after_steps: u64,
    sinks_m_per_s: f64,
    limits: &Limits,
) -> Desk {
    let limited = Config {
        limits: limits.clone(),
        ..config()
    };
    single_of(actuator, fault, (after_steps, sinks_m_per_s), limited)
}

/// The same with another test.
pub fn single_of(
    actuator: Actuator,
    fault: Option<InjectedFault>,
    (after_steps, sinks_m_per_s): (u64, f64),
    test: Config,
) -> Desk {
    let rig = format!(
        "[actuator]\nkind = 'delay'\ndelay_ms = {:?}\n[specimen]\nkind = 'linear'\n[sensors]\n",
        actuator.delay_ms
    );
    let mut desk = Desk::with(Bench {
        plan: fault.map(|fault| PlannedFault { after_steps, fault }),
        rig: Some(toml::from_str(&rig).expect("a rig")),
        sinks_m_per_s,
        valve_m_per_s: actuator.valve_m_per_s,
        ..Bench::default()
    });
    desk.load();
    let reply = desk.ask(Command::Configure(test.into()));
    assert!(matches!(reply, Reply::Done { .. }), "{reply:?}");
    for _ in 0..300 {
        desk.step();
    }
    desk
}

/// Positions of the piston while PERMIT was high for the first time, m.
fn permitted(log: &Log) -> &[f64] {
    let begin = log.permitted.iter().position(|p| *p);
    let begin = begin.unwrap_or(log.permitted.len());
    let steps = log.permitted[begin..].iter().take_while(|p| **p).count();
    &log.position_m[begin..begin + steps]
}

/// Asserts that the fault came before PERMIT fell for any reason.
fn assert_came(fault: InjectedFault, log: &Log) {
    let mut seen = log.seen.iter().map(|(_, seen)| seen);
    let first = seen.find(|s| matches!(s, LoggedEvent::Fault | LoggedEvent::Permit(false)));
    assert_eq!(first, Some(&LoggedEvent::Fault), "{fault:?} never came");
}

/// With a fault from the first sample: how far the piston goes beyond the approach, m; 0 if it is not armed.
fn beyond_before_arming(fault: InjectedFault, limits: &Limits) -> f64 {
    // It is some millimetres off zero: a board armed on a wrong reading jumps.
    let mut desk = single(USUAL, Some(fault), 0, 0.02, limits);
    let armed = matches!(desk.ask(Command::Event(Event::Arm)), Reply::Done { .. });
    for _ in 0..300 {
        desk.step();
    }
    let log = desk.log();
    assert_came(fault, &log);
    let at_m = permitted(&log);
    let approach_m = config().timing.approach_m_per_s * 0.5e-3;
    let beyond = at_m
        .iter()
        .enumerate()
        .map(|(step, m)| (m - at_m[0]).abs() - approach_m * step as f64);
    let beyond_m = beyond.fold(0.0, f64::max);
    println!(
        "{fault:?} before arming: armed {armed}, {:.2} mm",
        beyond_m * 1e3
    );
    beyond_m
}

/// A whole test, or its part until PERMIT falls: positions of the piston since the start, m. Empty if a fault from the first
/// sample prevents the start.
pub fn run(
    actuator: Actuator,
    fault: Option<InjectedFault>,
    after_steps: u64,
    limits: &Limits,
) -> Vec<f64> {
    let mut desk = single(actuator, fault, after_steps, 0.0, limits);
    let from_the_first = fault.is_some() && after_steps == 0;
    if from_the_first {
        if !matches!(desk.ask(Command::Event(Event::Arm)), Reply::Done { .. }) {
            return Vec::new();
        }
        let starts = (0..LONGEST_APPROACH).any(|_| {
            let step = desk.step();
            step.mode() == Some(Mode::Armed) && step.command_m == 0.0
        });
        // It may have tripped since: the motion until then is judged before arming.
        if !starts || !matches!(desk.ask(Command::Event(Event::Start)), Reply::Done { .. }) {
            return Vec::new();
        }
    } else {
        desk.order(Command::Event(Event::Arm));
        while desk.step().mode() != Some(Mode::Armed) {}
        while desk.step().command_m != 0.0 {}
        desk.order(Command::Event(Event::Start));
    }
    let mut moved = 0;
    let mut before_power_up = None;
    loop {
        desk.step();
        moved += 1;
        if moved % 100 == 0 {
            let log = desk.log();
            // Laboratory turns before the first period; taken before a fault can reset the chip.
            let sampled = *before_power_up.get_or_insert(log.position_m.len() - log.periods);
            let began = log.permitted.iter().position(|p| *p);
            let ended = began.is_some_and(|b| log.permitted[b..].contains(&false));
            let enough = fault.map_or(PLANNED_STEPS, |_| SEEN_STEPS);
            if ended || moved > enough {
                if let Some(fault) = fault {
                    assert_came(fault, &log);
                }
                let first = desk.steps.iter();
                let mut running = first.filter(|(_, s)| s.mode() == Some(Mode::Running));
                let tick = running.next().expect("it runs").0 as usize;
                let since = sampled + tick;
                let permitted = log.permitted[since..].iter().take_while(|p| **p);
                let steps = permitted.count();
                return log.position_m[since..since + steps].to_vec();
            }
        }
    }
}

/// How far the piston goes beyond the plan in a running test until PERMIT falls, m.
pub fn beyond_in_a_test(
    actuator: Actuator,
    fault: InjectedFault,
    after_steps: u64,
    plan: &[f64],
    limits: &Limits,
) -> f64 {
    let went = run(actuator, Some(fault), after_steps, limits);
    let held = BEHIND
        .contains(&fault)
        .then(|| (after_steps as usize).saturating_sub(BEFORE_THE_START));
    // The target leads a sound piston by the actuator's delay: neither is beyond the plan.
    let ahead = (actuator.delay_ms * STEPS_PER_MS) as usize;
    let apart = went.iter().enumerate().map(|(i, went)| {
        let since = held.map_or(i, |held| held.min(i));
        assert!(i < plan.len(), "the plan is too short");
        let places = plan[since..].iter().take(i + ahead + 1 - since);
        let nearest = places.map(|plan| (went - plan).abs());
        nearest.fold(f64::INFINITY, f64::min)
    });
    let beyond_m = apart.fold(0.0, f64::max);
    println!(
        "{fault:?} after {after_steps} steps: PERMIT fell {} steps after the start, {:.2} mm beyond the plan",
        went.len(),
        beyond_m * 1e3
    );
    beyond_m
}

pub fn each(actuator: Actuator, faults: &[InjectedFault], phases: &[u64]) -> Vec<String> {
    let plan = run(actuator, None, 0, &stated());
    let peak = plan.iter().fold(0.0_f64, |most, m| most.max(m.abs()));
    println!("the plan goes {:.1} mm far", peak * 1e3);
    assert!(peak > 0.005);
    let mut wrong = Vec::new();
    for fault in faults.iter().filter(|f| **f != LIKE_A_BREAK) {
        for after in phases {
            let beyond = beyond_in_a_test(actuator, *fault, *after, &plan, &stated());
            if beyond > BEYOND_M {
                wrong.push(format!("{fault:?} after {after}: {:.2} mm", beyond * 1e3));
            }
        }
    }
    wrong
}

fn each_before_arming(faults: &[InjectedFault]) -> Vec<String> {
    let far = faults
        .iter()
        .map(|f| (f, beyond_before_arming(*f, &stated())));
    let far = far.filter(|(_, beyond_m)| *beyond_m > BEYOND_M);
    far.map(|(fault, m)| format!("{fault:?} before arming: {:.2} mm", m * 1e3))
        .collect()
}

#[test]
fn a_load_cell_that_stands_in_its_converters_noise_moves_nothing_beyond_the_plan() {
    assert_eq!(each(USUAL, &[StandingForce], &PHASES[1..2]), [""; 0]);
}

#[test]
fn a_load_cell_that_comes_and_goes_moves_nothing_beyond_the_plan() {
    assert_eq!(each(USUAL, &[ForceFlickers], &PHASES[1..2]), [""; 0]);
}

/// Each opening adds to the actuator's delay, and the test's motion grows by that long before its tracking limit acts.
#[test]
fn a_contact_that_chatters_moves_nothing_beyond_the_plan_whatever_its_limits_are() {
    let plan = run(USUAL, None, 0, &stated());
    let chatters = Chain(Contact::Chatters);
    let beyond_m = beyond_in_a_test(USUAL, chatters, PHASES[1], &plan, &worked_out(&plan));
    assert!(beyond_m <= BEYOND_M, "{beyond_m} m");
}

/// The frames are valid, and show the rig's first position: only their lack of noise reveals it.
#[test]
fn an_input_converter_whose_results_stand_is_not_armed() {
    let mut desk = single(USUAL, Some(InputStands), 0, 0.02, &stated());
    let reply = desk.ask(Command::Event(Event::Arm));
    let lost = Some(Obstacle::Fault(Fault::Output));
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == lost),
        "{reply:?}"
    );
}

/// A running test with a fault, continued until the fault must have been detected.
pub fn met_in_a_test(fault: InjectedFault) -> Desk {
    let mut desk = single(USUAL, Some(fault), PHASES[1], 0.0, &stated());
    desk.order(Command::Event(Event::Arm));
    while desk.step().mode() != Some(Mode::Armed) {}
    while desk.step().command_m != 0.0 {}
    desk.order(Command::Event(Event::Start));
    for _ in 0..SEEN_STEPS {
        desk.step();
    }
    desk
}

// proves: fault.stale_sample by KnownVoltageFlickers
// proves: fault.output by ReadBackFlickers
// proves: fault.disagree by SecondSensorFlickers
#[test]
fn what_comes_and_goes_trips_though_no_run_of_bad_steps_is_long() {
    for (fault, reason) in [
        (KnownVoltageFlickers, Fault::StaleSample),
        (ReadBackFlickers, Fault::Output),
        (SecondSensorFlickers, Fault::Disagree),
        (ForceFlickers, Fault::ForceStands),
    ] {
        let mut desk = met_in_a_test(fault);
        assert_came(fault, &desk.log());
        let status = desk.status();
        assert_eq!(status.trip.map(|t| t.fault), Some(reason), "{fault:?}");
        assert!(!status.permit);
    }
}

// proves: fault.deadline_missed by SlowTimer
// proves: fault.deadline_missed by FastTimer
#[test]
fn a_sampling_timer_with_another_period_trips_in_the_first_one() {
    let plan = run(USUAL, None, 0, &stated());
    // The period in which it comes, unchanged, and one of 1.28 or 0.4 ms.
    for (fault, within_us) in [(SlowTimer, 2000), (FastTimer, 1200)] {
        let beyond_m = beyond_in_a_test(USUAL, fault, PHASES[1], &plan, &stated());
        assert!(beyond_m <= BEYOND_M, "{fault:?}: {beyond_m} m");
        let mut desk = met_in_a_test(fault);
        let status = desk.status();
        assert_eq!(status.trip.map(|t| t.fault), Some(Fault::DeadlineMissed));
        assert!(!status.permit);
        let course = desk.course();
        let after_us = (course.permit_low_ns - course.fault_ns) / 1000;
        println!("{fault:?}: PERMIT low {after_us} us after it");
        assert!(after_us < within_us, "{fault:?}: {after_us} us");
    }
}

#[test]
fn a_chain_whose_contact_is_not_read_moves_nothing_beyond_the_plan() {
    let unread = [Chain(Contact::Unread)];
    let mut wrong = each_before_arming(&unread);
    wrong.extend(each(USUAL, &unread, &PHASES[1..2]));
    assert_eq!(wrong, [""; 0]);
}

/// What the usual delay hides: until PERMIT falls, an actuator that responds in the next period moves at its valve's speed.
#[test]
fn a_wrong_output_moves_an_actuator_that_answers_at_once_less_than_2_mm() {
    // As in docs/hazards.md.
    for (valve_m_per_s, page_mm) in [(0.5, 1.13), (1.0, 1.26), (2.0, 1.13)] {
        let actuator = Actuator {
            valve_m_per_s,
            ..AT_ONCE
        };
        let plan = run(actuator, None, 0, &stated());
        let beyond_m = beyond_in_a_test(actuator, OutputDips, PHASES[1], &plan, &stated());
        println!("{valve_m_per_s} m/s: {:.2} mm", beyond_m * 1e3);
        assert!(
            (beyond_m * 1e3 - page_mm).abs() < 0.02,
            "{valve_m_per_s} m/s"
        );
    }
}

/// Faults from the first sample that do not block arming, or are over by then: the test is started with them.
#[test]
#[ignore = "nightly: five minutes"]
fn tests_that_start_with_a_single_fault_go_nowhere_beyond_the_plan() {
    assert_eq!(each(USUAL, &FAULTS, &[0]), [""; 0]);
}

/// Motion in a test without stated limits, whose piston position a person confirmed without looking.
#[test]
#[ignore = "nightly: ten minutes"]
fn how_far_single_faults_go_under_limits_that_are_worked_out() {
    let plan = run(USUAL, None, 0, &stated());
    let limits = worked_out(&plan);
    println!("{limits:?}");
    let mut farthest_m = 0.0_f64;
    for fault in FAULTS {
        let before_m = beyond_before_arming(fault, &limits);
        let running_m = beyond_in_a_test(USUAL, fault, PHASES[1], &plan, &limits);
        if before_m.max(running_m) > BEYOND_M {
            farthest_m = farthest_m.max(before_m).max(running_m);
            println!(
                "| `{fault:?}` | {:.1} | {:.1} |",
                before_m * 1e3,
                running_m * 1e3
            );
        }
    }
    // Under stated limits: no signal distinguishes it from another specimen.
    for percent in [50, 150] {
        beyond_in_a_test(USUAL, ForceGain { percent }, PHASES[0], &plan, &stated());
    }
    // The distance that the rig has sunk, for a transducer that is dead at arming.
    assert!((0.02..0.03).contains(&farthest_m), "{farthest_m} m");
}

/// Parts that run in parallel.
const PARTS: usize = 6;

/// Every fault before arming and near the peak of a running test; nightly at the other phases, and with a faster actuator.
macro_rules! parts {
    ($($name:ident $by_night:ident $part:literal)*) => {
        $(
            #[test]
            fn $name() {
                let mut wrong = each_before_arming(part($part));
                wrong.extend(each(USUAL, part($part), &PHASES[1..2]));
                assert_eq!(wrong, [""; 0]);
            }

            #[test]
            #[ignore = "nightly: all of them fifteen minutes"]
            fn $by_night() {
                let mut wrong = each(USUAL, part($part), &[PHASES[0], PHASES[2]]);
                wrong.extend(each(AT_ONCE, part($part), &PHASES[1..2]));
                assert_eq!(wrong, [""; 0]);
            }
        )*
    };
}

fn part(number: usize) -> &'static [InjectedFault] {
    &FAULTS[FAULTS.len() * number / PARTS..FAULTS.len() * (number + 1) / PARTS]
}

parts! {
    the_first_faults_move_nothing_beyond_the_plan the_first_faults_at_any_phase_move_nothing_beyond_the_plan 0
    the_second_faults_move_nothing_beyond_the_plan the_second_faults_at_any_phase_move_nothing_beyond_the_plan 1
    the_third_faults_move_nothing_beyond_the_plan the_third_faults_at_any_phase_move_nothing_beyond_the_plan 2
    the_fourth_faults_move_nothing_beyond_the_plan the_fourth_faults_at_any_phase_move_nothing_beyond_the_plan 3
    the_fifth_faults_move_nothing_beyond_the_plan the_fifth_faults_at_any_phase_move_nothing_beyond_the_plan 4
    the_sixth_faults_move_nothing_beyond_the_plan the_sixth_faults_at_any_phase_move_nothing_beyond_the_plan 5
}
