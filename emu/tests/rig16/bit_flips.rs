//! Single bits that turn over in a running test: none is dangerous in a few, and in many hardly any may be.

use crate::desk::image;
use emu::Firmware;
use emu::flips::{Outcome, Table, Target, Trials, run};

fn flips(flips: usize, seed: u64, only: Option<Target>) -> Table {
    let firmware = Firmware::read(image()).expect("an image");
    let trials = Trials {
        flips,
        seed,
        jobs: 2,
        only,
        number: None,
    };
    let table = run(&firmware, &trials, |line| println!("{line}")).expect("a table");
    println!("{table}");
    table
}

#[test]
fn bits_of_every_kind_turn_over_and_none_moves_the_piston_beyond_the_plan() {
    let table = flips(84, 1, None);
    assert_eq!(table.flips.len(), 84);
    assert_eq!(table.dangerous(), 0);
    // They are bits of what runs: a program counter, a code on its way to the output.
    assert!(table.count(Some(Target::Core), Outcome::Reset) > 0);
    assert!(table.count(Some(Target::Bus), Outcome::NoEffect) < 12);
}

#[test]
#[ignore = "nightly: an hour and more"]
fn of_two_thousand_bits_at_most_one_in_five_hundred_is_dangerous() {
    let table = flips(2000, 2, None);
    assert!(table.dangerous() <= 4, "{}", table.dangerous());
}
