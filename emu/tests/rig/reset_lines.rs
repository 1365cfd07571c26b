//! A reset line inside the chip is pulsed after set-up: its peripheral is as after power-up.

#[path = "../rig16/refused.rs"]
mod refused;

use crate::desk::{Bench, Desk};
use emu::{InjectedFault, LoggedEvent, PlannedFault, ResetLine};
use link::reply::Obstacle;
use outerloop_core::Fault;
use refused::{refuses, refuses_in_the_middle};

/// Largest motion allowed beyond the plan, m.
const BEYOND_M: f64 = 2e-3;

/// Control steps with PERMIT at which a line is pulsed: while the target rises, near its peak, and after it.
const PHASES: [u64; 3] = [1250, 1400, 1700];

/// Control steps from there to the end of the watch: the watchdog takes at most 100, the relay a few more.
const WATCHED: usize = 300;

/// The pin floats, and what reads it back sees the voltage that its charge keeps: only the DAC's own register shows it.
#[test]
fn an_output_that_its_reset_line_has_cleared_is_not_armed() {
    let line = InjectedFault::ResetLine(ResetLine::Dac);
    refuses_in_the_middle(line, Obstacle::Fault(Fault::Output));
}

/// The output stays where it is while the rig sinks.
#[test]
fn an_output_whose_timer_its_reset_line_has_cleared_is_not_armed() {
    let line = InjectedFault::ResetLine(ResetLine::OutputTimer);
    refuses(line, Obstacle::Fault(Fault::Output));
}

/// Positions of the piston with PERMIT high, and the events, in a running test; `after` steps with PERMIT the line is pulsed.
fn run(line: Option<ResetLine>, after: u64) -> (Vec<f64>, Vec<LoggedEvent>) {
    let mut desk = Desk::with(Bench {
        plan: line.map(|line| PlannedFault {
            after_steps: after,
            fault: InjectedFault::ResetLine(line),
        }),
        ..Bench::default()
    });
    desk.start();
    loop {
        desk.turn();
        let log = desk.log();
        let begin = log.permitted.iter().position(|p| *p).expect("PERMIT");
        if log.permitted.len() > begin + after as usize + WATCHED {
            let permitted = log.permitted[begin..].iter().take_while(|p| **p);
            let at_m = &log.position_m[begin..begin + permitted.count()];
            return (at_m.to_vec(), log.seen.iter().map(|(_, s)| *s).collect());
        }
    }
}

/// How far the piston goes beyond the plan until PERMIT falls, m. It may stand where it was.
fn beyond(line: ResetLine, after: u64, plan: &[f64]) -> f64 {
    let (went, seen) = run(Some(line), after);
    assert!(seen.contains(&LoggedEvent::Fault), "{line:?} never came");
    assert!(
        went.len() < after as usize + WATCHED,
        "{line:?}: PERMIT stays"
    );
    let off = went.iter().enumerate().map(|(i, went)| {
        let since = i.min(after as usize - 1);
        let nearest = plan[since..=i].iter().map(|plan| (went - plan).abs());
        nearest.fold(f64::INFINITY, f64::min)
    });
    let beyond_m = off.fold(0.0, f64::max);
    let resets = seen.contains(&LoggedEvent::Reset);
    println!(
        "{line:?} after {after} steps: PERMIT low {} steps later, reset {resets}, {:.2} mm beyond the plan",
        went.len() as u64 - after,
        beyond_m * 1e3
    );
    beyond_m
}

#[test]
fn no_reset_line_moves_the_piston_beyond_the_plan() {
    let (plan, _) = run(None, PHASES[2]);
    for line in [
        ResetLine::Adc,
        ResetLine::Dac,
        ResetLine::SamplingTimer,
        ResetLine::OutputTimer,
    ] {
        for after in PHASES {
            let beyond_m = beyond(line, after, &plan);
            assert!(beyond_m <= BEYOND_M, "{line:?} after {after}: {beyond_m} m");
        }
    }
}
