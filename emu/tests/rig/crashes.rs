//! What ends the program, or should: each leaves PERMIT low, the command held, and the reason readable.

use crate::desk::{Bench, Course, Desk, PERIOD_NS, codes, fine};
use emu::nucleo::HEALTHY_MV;
use emu::{InjectedFault, LoggedEvent, PlannedFault};
use link::command::Command;
use link::reply::{Obstacle, Reply};
use link::status::{CrashCause, CrashReport, StartCause, Status};
use outerloop_cli::board::Image;
use outerloop_core::{Event, Fault, Mode};

const MS: u64 = 1_000_000;

/// The background looks for a drill ten times a second.
pub(crate) const NOTICED_NS: u64 = 100 * MS;

/// The watchdog's 25 ms at its slowest clock.
pub(crate) const WATCHDOG_NS: u64 = 50 * MS;

/// Positions of the stack's end within a frame of the drill, 80 bytes, in steps of eight bytes.
const PLACES: u32 = 10;

/// A fault in the middle of a test, 0.3 s after PERMIT came.
fn in_mid_test(fault: InjectedFault) -> Desk {
    on_bench(fault, Bench::default())
}

fn on_bench(fault: InjectedFault, bench: Bench) -> Desk {
    let plan = Some(PlannedFault {
        after_steps: 600,
        fault,
    });
    let mut desk = Desk::with(Bench { plan, ..bench });
    desk.start();
    desk
}

/// A drill that ends in a reset by the watchdog.
fn crash(drill: u32) -> (Course, Status) {
    crash_on(drill, Bench::default())
}

fn crash_on(drill: u32, bench: Bench) -> (Course, Status) {
    let mut desk = on_bench(InjectedFault::Drill(drill), bench);
    desk.until_reset();
    desk.assert_nothing_lost();
    let status = desk.status();
    let course = desk.course();
    assert_eq!(
        (status.started, status.mode),
        (StartCause::Watchdog, Mode::Idle)
    );
    assert!(!status.permit);
    // The specimen is where the last command put it, and the converter starts there again.
    let first = course.first_after_reset.expect("the board started again");
    assert!(
        first.abs_diff(course.held) <= 3 * fine(),
        "{} after {}",
        first,
        course.held
    );
    // It takes a new test.
    desk.start();
    desk.until(Mode::Running);
    (course, status)
}

pub(crate) fn words(status: &Status) -> &CrashReport {
    status.last_crash.as_ref().expect("a crash report")
}

/// PERMIT goes low at once, nothing moves the converter any more, the watchdog resets, and the cause is reported. Returns the
/// text of the crash report.
fn dies_at_once(drill: u32, cause: CrashCause) -> String {
    let (course, status) = crash(drill);
    let after = course.permit_low_ns - course.fault_ns;
    assert!(after <= NOTICED_NS + PERIOD_NS, "{after} ns");
    assert_eq!(course.written_before_reset, [0; 0]);
    let reset = course.reset_ns.expect("a reset") - course.permit_low_ns;
    assert!(reset <= WATCHDOG_NS, "{reset} ns");
    let last = words(&status);
    assert_eq!((last.cause, last.mode), (cause, Mode::Running));
    println!(
        "drill {drill}: PERMIT low {} ms after, reset {} ms later: {}",
        after / MS,
        reset / MS,
        last.text
    );
    last.text.to_string()
}

#[test]
fn a_panic() {
    let text = dies_at_once(1, CrashCause::Panic);
    assert!(
        text.starts_with("drill.rs:") && text.ends_with("a drill"),
        "{text}"
    );
}

#[test]
fn a_hard_fault() {
    let text = dies_at_once(2, CrashCause::HardFault);
    assert!(text.starts_with("pc 0x080"), "{text}");
}

#[test]
fn a_clock_that_stops() {
    let text = dies_at_once(7, CrashCause::ClockStopped);
    assert_eq!(text, "the external clock stopped");
}

#[test]
fn a_supply_that_falls() {
    let text = dies_at_once(8, CrashCause::LowSupply);
    assert_eq!(text, "the supply fell below 2.9 V");
}

/// The watchdog's clock is accurate to a factor of two: at its slowest and at its fastest a test runs, and a hang ends.
#[test]
fn the_watchdogs_clock_at_both_ends_of_its_range() {
    for lsi_hz in [17_000, 47_000] {
        let bench = Bench {
            lsi_hz,
            ..Bench::default()
        };
        let (course, status) = crash_on(5, bench);
        assert!(status.crystal_ok, "{lsi_hz} Hz");
        let reset = course.reset_ns.expect("a reset") - course.fault_ns;
        println!(
            "slow clock {lsi_hz} Hz: reset {} ms after the hang was asked for",
            reset / MS
        );
        assert!(reset <= NOTICED_NS + WATCHDOG_NS, "{reset} ns");
    }
}

#[test]
fn an_exhausted_stack() {
    dies_at_once(3, CrashCause::StackOverflow);
}

/// A debugger has set the core to halt at faults and has gone: with PERMIT high no fault halts it, and the program handles it.
#[test]
fn a_debugger_that_wanted_to_see_faults_halts_none_with_permit() {
    const DEMCR: u64 = 0xe000_edfc;
    /// VC_HARDERR and VC_BUSERR (ARMv7-M, C1.6.5).
    const HALTS: [u32; 2] = [10, 8];
    /// Needed by the cycle counter.
    const TRACE: u64 = 1 << 24;
    let (mut desk, processor) = Desk::running_looked_into();
    processor.look_at([DEMCR]);
    for bit in HALTS {
        processor.turn_over_system(DEMCR, bit);
        // Telemetry arrives in bundles.
        for _ in 0..100 {
            desk.step();
        }
        assert_eq!(processor.found(DEMCR), Some(TRACE), "bit {bit}");
    }
}

/// The fault status in the report has a bit of the memory protection unit and none of the bus: on this chip the bus need not
/// fault below the memory.
fn refused_by_memory_protection(text: &str) -> bool {
    let status = text.split("CFSR 0x").nth(1);
    let status = status.and_then(|digits| u32::from_str_radix(digits, 16).ok());
    status.is_some_and(|status| status & 0xff != 0 && status & 0xff00 == 0)
}

/// At every position of the stack's end in a frame. At one of ten the emulated chip once went on as if nothing had happened:
/// accesses below the memory did not fault there, and the drill read zero.
#[test]
fn an_exhausted_stack_is_seen_wherever_a_frame_begins() {
    if crate::IMAGE != Image::Internal {
        // The end of the stack is the same on every image.
        return;
    }
    let drills = (0..PLACES).map(|eights| PlannedFault {
        after_steps: 0,
        fault: InjectedFault::Drill(0x30 + eights),
    });
    let mut desk = Desk::with(Bench {
        then: drills.collect(),
        ..Bench::default()
    });
    for eights in 0..PLACES {
        desk.until_reset();
        let status = desk.status();
        let last = words(&status);
        assert_eq!(
            last.cause,
            CrashCause::StackOverflow,
            "{eights}: {}",
            last.text
        );
        assert!(refused_by_memory_protection(&last.text), "{}", last.text);
    }
    let seen = desk.log().seen;
    let when_ns = |what| {
        seen.iter()
            .filter(move |(_, s)| *s == what)
            .map(|(ns, _)| ns)
    };
    for (fault, reset) in when_ns(LoggedEvent::Fault).zip(when_ns(LoggedEvent::Reset)) {
        let after = reset - fault;
        assert!(after <= NOTICED_NS + WATCHDOG_NS, "{after} ns");
    }
}

// proves: fault.starved by crash(4)
#[test]
fn a_starved_task_trips_the_test_before_the_watchdog_resets() {
    let (course, status) = crash(4);
    let after = course.permit_low_ns - course.fault_ns;
    // The time to notice it, and the timeout of a task.
    assert!(after <= 2 * NOTICED_NS + 2 * PERIOD_NS, "{after} ns");
    assert!(
        course
            .written_before_reset
            .iter()
            .all(|&c| c == course.held),
        "{course:?}"
    );
    let reset = course.reset_ns.expect("a reset") - course.permit_low_ns;
    assert!(reset <= WATCHDOG_NS, "{reset} ns");
    let last = words(&status);
    // Tripped before the reset. Only Fault::Starved trips so soon: a lost link takes half a second.
    assert_eq!(
        (last.cause, last.mode),
        (CrashCause::Starved, Mode::Tripped)
    );
}

#[test]
fn a_program_that_hangs_with_interrupts_off_is_reset() {
    let (course, status) = crash(5);
    let after = course.permit_low_ns - course.fault_ns;
    assert!(after <= NOTICED_NS + WATCHDOG_NS, "{after} ns");
    assert_eq!(words(&status).cause, CrashCause::Silent);
}

// proves: fault.deadline_missed by Drill(6)
#[test]
fn a_step_that_takes_too_long_trips_in_the_next() {
    let mut desk = in_mid_test(InjectedFault::Drill(6));
    desk.until(Mode::Tripped);
    let status = desk.status();
    assert_eq!(status.trip.map(|t| t.fault), Some(Fault::DeadlineMissed));
    assert_eq!(status.timing.overruns, 1);
    assert_eq!(status.started, StartCause::Power);
    let course = desk.course();
    let after = course.permit_low_ns - course.fault_ns;
    println!("DeadlineMissed: PERMIT low {} us after it", after / 1000);
    assert!(after <= 2 * PERIOD_NS + PERIOD_NS / 2, "{after} ns");
    assert!(
        course
            .written_before_reset
            .iter()
            .all(|&c| c == course.held)
    );
    desk.assert_nothing_lost();
}

// proves: fault.emergency_stop, obstacle.fault by EmergencyStop
#[test]
fn the_emergency_stop_acts_in_one_period_and_stands_against_arming() {
    let mut desk = in_mid_test(InjectedFault::EmergencyStop);
    desk.until(Mode::Tripped);
    let course = desk.course();
    let after = course.permit_low_ns - course.fault_ns;
    println!("EmergencyStop: PERMIT low {} us after it", after / 1000);
    assert!(after <= PERIOD_NS, "{after} ns");
    for _ in 0..200 {
        desk.step();
    }
    let course = desk.course();
    assert!(
        course
            .written_before_reset
            .iter()
            .all(|&c| c == course.held)
    );
    assert_eq!(
        desk.status().trip.map(|t| t.fault),
        Some(Fault::EmergencyStop)
    );
    desk.order(Command::Event(Event::Clear));
    let reply = desk.ask(Command::Event(Event::Arm));
    let pressed = Some(Obstacle::Fault(Fault::EmergencyStop));
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == pressed),
        "{reply:?}"
    );
    desk.assert_nothing_lost();
}

#[test]
fn the_reset_button_in_mid_test() {
    let mut desk = in_mid_test(InjectedFault::Reset);
    desk.until_reset();
    let status = desk.status();
    assert_eq!(
        (status.started, status.mode, status.permit),
        (StartCause::Pin, Mode::Idle, false)
    );
    let course = desk.course();
    // The pins float at once.
    assert_eq!(course.permit_low_ns, course.fault_ns);
    if crate::IMAGE == Image::Internal {
        // The chip's own output floats with it: until the relay has fallen, 10 ms, nothing commands the rig.
        return;
    }
    let first = course.first_after_reset.expect("the board started again");
    assert!(
        first.abs_diff(course.held) <= 3 * fine(),
        "{} after {}",
        first,
        course.held
    );
    desk.start();
    desk.until(Mode::Running);
}

/// Oil leaks: without PERMIT the rig sinks. The board starts where it is then, not where it was commanded to be.
#[test]
fn the_reset_button_on_a_rig_that_sinks_without_permit() {
    if crate::IMAGE == Image::Internal {
        // Its own output floats until the relay has fallen: the rig may be anywhere then, see docs/wiring.md.
        return;
    }
    // It also sinks before it is armed, so the approach takes time.
    let mut desk = Desk::with(Bench {
        plan: Some(PlannedFault {
            after_steps: 3000,
            fault: InjectedFault::Reset,
        }),
        sinks_m_per_s: 0.001,
        ..Bench::default()
    });
    desk.start();
    desk.until_reset();
    for _ in 0..1000 {
        desk.step();
    }
    let log = desk.log();
    let last_m = *log.position_m.last().expect("a position");
    let line = link::Calibration::nominal(&codes()).command;
    let held_m = f64::from(line.quantity(desk.course().held));
    assert!(
        last_m < held_m - 2e-4,
        "it has sunk from {held_m} m to {last_m} m"
    );
    // In idle the command follows the position: arming causes no jump.
    let shown = log
        .pin
        .last()
        .copied()
        .flatten()
        .expect("the pin is driven");
    let off_m = f64::from(line.quantity(shown)) - last_m;
    // The travel in a period, the sensor's delay, and a code.
    assert!(off_m.abs() < 2e-4, "{off_m} m from where the rig is");
    desk.start();
    desk.until(Mode::Running);
}

#[test]
fn a_supply_that_is_low_from_the_start_is_waited_for() {
    for (supply_mv, begins) in [(HEALTHY_MV, true), (2_800, false)] {
        let mut desk = Desk::with(Bench {
            supply_mv,
            ..Bench::default()
        });
        // The laboratory runs twice a millisecond while nothing samples; the board's time advances while the PC steps.
        while desk.log().position_m.len() < 400 {
            desk.turn();
        }
        assert_eq!(desk.log().periods > 0, begins, "{supply_mv} mV");
    }
}

// proves: obstacle.crystal by crystal_hz
#[test]
fn a_wrong_or_missing_crystal_is_seen_and_nothing_can_be_armed() {
    for crystal_hz in [25_000_000, 7_000_000, 0] {
        let mut desk = Desk::with(Bench {
            crystal_hz,
            ..Bench::default()
        });
        desk.load();
        let status = desk.status();
        assert!(!status.crystal_ok, "{crystal_hz} Hz");
        let reply = desk.ask(Command::Event(Event::Arm));
        let obstacle = Some(Obstacle::Crystal);
        assert!(
            matches!(&reply, Reply::Rejected { obstacle: o, .. } if *o == obstacle),
            "{reply:?}"
        );
        assert!(
            !desk
                .log()
                .seen
                .iter()
                .any(|(_, s)| *s == LoggedEvent::Permit(true))
        );
    }
}
