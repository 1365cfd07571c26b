//! What may end a commissioning signal, as docs/commissioning.md has it tried before a specimen is attached: the emergency stop,
//! a cut link, the loss of power. Each leaves PERMIT low, the piston where the signal was, the reason readable, and nothing that
//! moves by itself.

use crate::crashes::{NOTICED_NS, WATCHDOG_NS, words};
use crate::desk::{Bench, Desk, PERIOD_NS, codes, fine};
use crate::limits_and_link::{configured, trips};
use emu::{InjectedFault, Log, PlannedFault};
use link::Calibration;
use link::command::{Command, CommissioningSignal, SignalShape};
use link::reply::{Obstacle, Reply};
use link::status::{CrashCause, StartCause};
use outerloop_cli::board::Image;
use outerloop_core::{Event, Fault, Mode};
use std::f64::consts::TAU;

/// The page's first sine, 1 mm at 1 Hz: the rise and the fall take half a second each.
const SIGNAL: CommissioningSignal = CommissioningSignal {
    actuator: 0,
    shape: SignalShape::Sine { frequency_hz: 1.0 },
    amplitude_m: 1e-3,
    seconds: 2.2,
};

/// Steps after PERMIT at which the fault comes: some 0.97 s into the signal, with the piston near zero and at its fastest.
const AFTER: u64 = 2000;

/// Steps from the fault to beyond the signal's own end.
const TO_ITS_END: usize = 2500;

/// So gentle that the ramp from 6 mm/s takes more than a tenth of a second, and many codes.
const DECELERATION_M_PER_S2: f64 = 0.05;

const STEP_S: f64 = PERIOD_NS as f64 * 1e-9;

/// The actuator's delay, s.
const DELAY_S: f64 = 3e-3;

/// How far the piston may be from where it has to be, m: a twentieth of the 2 mm of the single faults. It is half a code of the
/// output off and some steps behind, 12 um and 6 um a millisecond.
const OFF_M: f64 = 0.1e-3;

/// The sine's command, t seconds after its start, m.
fn planned_m(t_s: f64) -> f64 {
    let rise = (t_s / 0.5).clamp(0.0, 1.0);
    let rise = rise * rise * (3.0 - 2.0 * rise);
    f64::from(SIGNAL.amplitude_m) * rise * (TAU * t_s).sin()
}

/// Its speed there, m/s.
fn speed_m_per_s(t_s: f64) -> f64 {
    (planned_m(t_s + STEP_S) - planned_m(t_s - STEP_S)) / (2.0 * STEP_S)
}

/// How long a ramp takes that begins there, s.
fn ramp_s(t_s: f64) -> f64 {
    speed_m_per_s(t_s).abs() / DECELERATION_M_PER_S2
}

/// A board that plays the sine under the page's small limits, and on which the fault comes in its middle.
fn playing(fault: InjectedFault) -> Desk {
    let plan = Some(PlannedFault {
        after_steps: AFTER,
        fault,
    });
    let bench = Bench {
        plan,
        ..Bench::default()
    };
    let mut desk = configured(bench, |c| {
        c.limits.displacement_m = Some(0.005);
        c.limits.velocity_m_per_s = Some(0.02);
        c.limits.tracking_m = Some(0.002);
        c.limits.force_n = Some(500.0);
        c.timing.hold_deceleration_m_per_s2 = DECELERATION_M_PER_S2;
    });
    desk.order(Command::Signal(Some(SIGNAL)));
    desk.arm_and_start();
    desk.until(Mode::Commissioning);
    desk
}

/// The signal's periods in the laboratory's log.
struct Played {
    log: Log,
    /// Place of its first step.
    began: usize,
    /// Places of the fault, and of the first period without PERMIT.
    fault: usize,
    low: usize,
}

impl Played {
    /// `before_power_up`: the laboratory's turns before the first period, which are in its log too.
    fn of(desk: &Desk, before_power_up: usize) -> Self {
        let log = desk.log();
        let mut steps = desk.steps.iter();
        let first = steps.find(|(_, s)| s.mode() == Some(Mode::Commissioning));
        let first_tick = first.expect("the signal ran").0;
        let high = log.permitted.iter().position(|p| *p);
        let high = high.expect("PERMIT was high");
        let low = log.permitted[high..].iter().position(|p| !p);
        let low = high + low.expect("PERMIT is low");
        assert!(!log.permitted[low..].contains(&true), "it came back");
        Self {
            began: before_power_up + first_tick as usize,
            fault: high + AFTER as usize,
            low,
            log,
        }
    }

    /// Seconds since the signal's start.
    fn at_s(&self, place: usize) -> f64 {
        (place - self.began) as f64 * STEP_S
    }

    /// Where a ramp must have begun for PERMIT to fall at its end.
    fn ramp_begins(&self) -> usize {
        let late_s = |place: usize| {
            let begun_s = self.at_s(place);
            (begun_s + ramp_s(begun_s) - self.at_s(self.low)).abs()
        };
        let places = self.fault..self.low;
        let best = places.min_by(|a, b| late_s(*a).total_cmp(&late_s(*b)));
        best.expect("PERMIT falls after the fault")
    }

    /// Since PERMIT fell the piston has been within [`OFF_M`] of `there_m`.
    fn stands_at(&self, there_m: f64) {
        let since = self.log.position_m[self.low..].iter();
        let off_m = since.fold(0.0, |most: f64, m| most.max((m - there_m).abs()));
        println!(
            "PERMIT low {:.3} s into the signal; the piston is {:.3} mm at most from where it had to stop, {:.3} mm",
            self.at_s(self.low),
            off_m * 1e3,
            there_m * 1e3
        );
        assert!(off_m <= OFF_M, "{off_m} m");
    }

    /// The piston goes by the sine, as late as its actuator is, up to this place.
    fn goes_on_until(&self, end: usize) {
        let gone = (self.fault..end).map(|place| {
            let planned_m = planned_m(self.at_s(place) - DELAY_S);
            (self.log.position_m[place] - planned_m).abs()
        });
        let off_m = gone.fold(0.0, f64::max);
        println!("{:.3} mm from the sine until then", off_m * 1e3);
        assert!(off_m <= OFF_M, "{off_m} m");
    }
}

/// Laboratory turns before the first period; asked before a reset, after which there are more.
fn before_power_up(desk: &Desk) -> usize {
    let log = desk.log();
    log.position_m.len() - log.periods
}

/// `Start` is refused: nothing can go on.
fn is_not_started(desk: &mut Desk) {
    let mode = desk.status().mode;
    let reply = desk.ask(Command::Event(Event::Start));
    let refused = Reply::Rejected {
        mode,
        event: Some(Event::Start),
        obstacle: None,
    };
    assert_eq!(reply, refused);
}

/// `Arm` is refused, for this reason.
fn is_not_armed(desk: &mut Desk, why: Obstacle) {
    let reply = desk.ask(Command::Event(Event::Arm));
    assert!(
        matches!(reply, Reply::Rejected { obstacle, .. } if obstacle == Some(why)),
        "{reply:?}"
    );
}

/// Nothing goes on by itself: each of these steps is in `mode`, and PERMIT is low.
fn stays(desk: &mut Desk, mode: Mode, steps: usize) {
    for _ in 0..steps {
        assert_eq!(desk.step().mode(), Some(mode));
    }
    assert!(!desk.status().permit);
}

// proves: fault.emergency_stop, obstacle.fault by EmergencyStop
#[test]
fn the_emergency_stop_ends_a_commissioning_signal_in_one_period() {
    let mut desk = playing(InjectedFault::EmergencyStop);
    let before = before_power_up(&desk);
    desk.until(Mode::Tripped);
    stays(&mut desk, Mode::Tripped, TO_ITS_END);
    let after = trips(&mut desk, Fault::EmergencyStop).expect("it was pressed");
    assert!(after <= PERIOD_NS, "{after} ns");
    is_not_armed(&mut desk, Obstacle::Fault(Fault::EmergencyStop));
    desk.assert_nothing_lost();
    let played = Played::of(&desk, before);
    played.stands_at(planned_m(played.at_s(played.fault)));
}

// proves: fault.link_lost by LinkCut
#[test]
fn a_cut_link_ends_a_commissioning_signal_on_the_ramp_and_nothing_goes_on_when_it_is_mended() {
    let mut desk = playing(InjectedFault::LinkCut(2000));
    let before = before_power_up(&desk);
    desk.until(Mode::Tripped);
    // The line was mended before the signal's own end.
    stays(&mut desk, Mode::Tripped, TO_ITS_END);
    is_not_started(&mut desk);
    let after = trips(&mut desk, Fault::LinkLost).expect("it was cut");
    desk.until(Mode::Idle);
    stays(&mut desk, Mode::Idle, 400);
    is_not_started(&mut desk);
    let played = Played::of(&desk, before);
    let lost = played.ramp_begins();
    let lost_s = played.at_s(lost);
    let (speed_m_per_s, ramp_s) = (speed_m_per_s(lost_s), ramp_s(lost_s));
    let way_m = 0.5 * speed_m_per_s * ramp_s;
    let silent_ms = (lost_s - played.at_s(played.fault)) * 1e3;
    println!(
        "silent for {silent_ms} ms, then from {:.2} mm/s to a standstill in {:.1} ms and {:.3} mm; PERMIT low {:.1} ms after the cut",
        speed_m_per_s * 1e3,
        ramp_s * 1e3,
        way_m * 1e3,
        after as f64 * 1e-6
    );
    // Half a second after the last message, which was up to a tenth old.
    assert!((395.0..=501.0).contains(&silent_ms), "{silent_ms} ms");
    played.goes_on_until(lost);
    assert!(way_m.abs() > OFF_M, "no ramp would be seen: {way_m} m");
    played.stands_at(planned_m(lost_s) + way_m);
}

/// Of what can be injected, a reset is nearest to a loss of power: every pin floats at once, PERMIT is pulled down outside, and the
/// program begins anew with nothing of the signal. The chip then names its pin as the cause and not its supply.
#[test]
fn a_board_that_is_reset_in_a_commissioning_signal_starts_idle_and_says_why() {
    let mut desk = playing(InjectedFault::Reset);
    let before = before_power_up(&desk);
    desk.until_reset();
    let status = desk.status();
    assert_eq!(
        (status.started, status.mode, status.trip),
        (StartCause::Pin, Mode::Idle, None)
    );
    let course = desk.course();
    assert_eq!(course.permit_low_ns, course.fault_ns);
    has_forgotten_the_signal(&mut desk);
    let played = Played::of(&desk, before);
    // The chip's own output floats until the relay has fallen, and the rig may go anywhere in those 10 ms.
    if crate::IMAGE != Image::Internal {
        holds_its_output(&desk);
        played.stands_at(planned_m(played.at_s(played.fault)));
    }
}

/// What a board does that still has time to: its supply falls below 2.9 V before it is gone. The drill raises the guard's
/// interrupt.
#[test]
fn a_supply_that_falls_in_a_commissioning_signal_leaves_its_reason() {
    let mut desk = playing(InjectedFault::Drill(8));
    let before = before_power_up(&desk);
    desk.until_reset();
    let status = desk.status();
    assert_eq!(
        (status.started, status.mode, status.permit),
        (StartCause::Watchdog, Mode::Idle, false)
    );
    let last = words(&status);
    assert_eq!(
        (last.cause, last.mode),
        (CrashCause::LowSupply, Mode::Commissioning)
    );
    let course = desk.course();
    let after = course.permit_low_ns - course.fault_ns;
    assert!(after <= NOTICED_NS + PERIOD_NS, "{after} ns");
    assert_eq!(course.written_before_reset, [0; 0]);
    let reset = course.reset_ns.expect("a reset") - course.permit_low_ns;
    assert!(reset <= WATCHDOG_NS, "{reset} ns");
    println!(
        "PERMIT low {} ms after the drill, reset {} ms later: {}",
        after / 1_000_000,
        reset / 1_000_000,
        last.text
    );
    has_forgotten_the_signal(&mut desk);
    holds_its_output(&desk);
    let played = Played::of(&desk, before);
    played.goes_on_until(played.low);
    played.stands_at(planned_m(played.at_s(played.low)));
}

/// It stays idle, and neither the signal nor anything else can be started.
fn has_forgotten_the_signal(desk: &mut Desk) {
    stays(desk, Mode::Idle, TO_ITS_END);
    is_not_started(desk);
    is_not_armed(desk, Obstacle::NotCalibrated);
}

/// After the restart the output begins where it was, and follows the piston, which stands.
fn holds_its_output(desk: &Desk) {
    let course = desk.course();
    let first = course.first_after_reset.expect("the board started again");
    assert!(
        first.abs_diff(course.held) <= 3 * fine(),
        "{first} after {}",
        course.held
    );
    let log = desk.log();
    let shown = log.pin.last().copied().flatten();
    let line = Calibration::nominal(&codes()).command;
    let shown_m = f64::from(line.quantity(shown.expect("the pin is driven")));
    let stands_m = *log.position_m.last().expect("a position");
    assert!(
        (shown_m - stands_m).abs() <= OFF_M,
        "{shown_m} of {stands_m} m"
    );
}
