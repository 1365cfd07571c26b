//! Converters for three actuators that have failed since the board started.

#[path = "../rig16/refused.rs"]
mod refused;

use emu::{InjectedFault, ResetLine};
use link::reply::Obstacle;
use outerloop_core::Fault;
use refused::{refuses, refuses_in_the_middle};

#[test]
fn an_output_converter_that_has_lost_its_supply_for_a_moment_is_not_armed() {
    refuses(InjectedFault::OutputDips, Obstacle::Fault(Fault::Output));
}

#[test]
fn an_output_converter_that_has_lost_its_supply_in_the_middle_of_the_stroke_is_not_armed() {
    refuses_in_the_middle(InjectedFault::OutputDips, Obstacle::Fault(Fault::Output));
}

/// It reads the commands back.
#[test]
fn outputs_whose_further_converter_its_reset_line_has_cleared_are_not_armed() {
    let line = InjectedFault::ResetLine(ResetLine::Adc);
    refuses_in_the_middle(line, Obstacle::Fault(Fault::Output));
}

#[test]
fn a_data_line_that_is_dead_or_stuck_gives_no_sample_and_nothing_is_armed() {
    for high in [false, true] {
        let stale = Obstacle::Fault(Fault::StaleSample);
        refuses(InjectedFault::StuckData { high }, stale);
    }
}
