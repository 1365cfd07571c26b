//! An image with one register wrong: how it is run, and what is checked.

use crate::desk::{Bench, Desk};
use emu::Mutant;

/// The effect of a mutant on the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Does {
    /// No sample is taken: not one control step.
    SamplesNothing,
    /// The output pin stays where the start has put it, or floats.
    ShowsNothing,
    /// No sample is valid, so nothing is written to the output after the start.
    #[allow(dead_code)] // The chip's own converters have no such case.
    WritesNothing,
    /// It runs, and the registers alone show what is wrong.
    Runs,
}

/// The demand that is not met, the register, the bits cleared and set in it, and the effect.
pub type Case = (&'static str, u64, u64, u64, Does);

#[test]
fn the_image_itself_meets_every_demand() {
    let desk = Desk::new(None);
    wait(&desk, 50);
    let log = desk.log();
    let found: Vec<String> = log.violations.iter().map(ToString::to_string).collect();
    assert_eq!(found, [""; 0]);
    assert!(log.triggers_ns.len() > 40);
}

/// Every case has its stated effect.
pub fn each_is_seen(cases: &[Case]) {
    let wrong: Vec<String> = cases.iter().filter_map(|case| run(case).err()).collect();
    assert_eq!(wrong, [""; 0]);
}

/// Returns an error if the effect is not as the case says.
fn run(&(name, address, clear, set, does): &Case) -> Result<(), String> {
    let desk = Desk::with(Bench {
        mutant: Some(Mutant {
            address,
            clear,
            set,
        }),
        // A working output follows the sinking rig.
        sinks_m_per_s: 0.02,
        ..Bench::default()
    });
    wait(&desk, 60);
    let log = desk.log();
    let found: Vec<&str> = log.violations.iter().map(|v| v.demand.name).collect();
    if found != [name] {
        return Err(format!("{name}: seen is {found:?}"));
    }
    println!("{}", log.violations[0]);
    let samples = log.triggers_ns.len();
    let commands = log.step_instructions.len();
    // The pin's latest codes, while it does not float.
    let shown: Vec<_> = log.pin.iter().rev().take(40).flatten().collect();
    let stands = shown.windows(2).all(|w| w[0] == w[1]);
    let as_said = match does {
        Does::SamplesNothing => samples == 0 && commands == 0,
        Does::WritesNothing => samples > 40 && commands == 0 && stands,
        Does::ShowsNothing => samples > 40 && commands > 40 && stands,
        Does::Runs => samples > 40 && commands > 40 && !stands,
    };
    as_said.then_some(()).ok_or(format!(
        "{name}: {samples} samples, {commands} commands, the pin stands: {stands}"
    ))
}

/// Waits until the laboratory has seen `periods` periods of the running timer.
fn wait(desk: &Desk, periods: usize) {
    for _ in 0..400 {
        if desk.log().periods >= periods {
            return;
        }
        desk.wire.exchange(&[]);
    }
    panic!("the board does not start");
}
