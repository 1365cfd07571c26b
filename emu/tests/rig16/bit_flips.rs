//! Single bit flips in a running test: none of a few is dangerous. Of many at most 1 in 500 is: `scripts/bit-flips`, each night.

use crate::desk::{Bench, Desk, codes, image};
use emu::flips::{Outcome, Target, Trials, run};
use emu::{CoreBits, Firmware, LoggedEvent};
use link::frame::checksum;
use link::{Calibration, Command};
use outerloop_core::{Event, Fault, Mode};

#[test]
fn bits_of_every_kind_turn_over_and_none_moves_the_piston_beyond_the_plan() {
    let firmware = Firmware::read(image()).expect("an image");
    let trials = Trials {
        flips: 84,
        seed: 1,
        jobs: 2,
        number: None,
    };
    let table = run(&firmware, &trials, |line| println!("{line}")).expect("a table");
    println!("{table}");
    assert_eq!(table.flips.len(), 84);
    assert_eq!(table.dangerous(), 0);
    // The flips hit what is in use: codes in transfer.
    assert!(table.count(Some(Target::Bus), Outcome::NoEffect) < 12);
}

/// Twelve drawn bits of the processor are often all harmless; this one is not.
#[test]
fn a_program_counter_that_leaves_the_memory_resets_the_board_and_the_piston_stands() {
    const PROGRAM_COUNTER: u32 = 15;
    let firmware = Firmware::read(image()).expect("an image");
    let processor = CoreBits::default();
    let mut desk = Desk::with(Bench {
        firmware: Some(firmware),
        processor: Some(processor.clone()),
        ..Bench::default()
    });
    desk.start();
    desk.until(Mode::Running);
    for _ in 0..100 {
        assert_eq!(desk.step().mode(), Some(Mode::Running));
    }
    let before = desk.log().seen.len();
    processor.turn_over_register(PROGRAM_COUNTER, 30);
    for _ in 0..400 {
        desk.step();
    }
    let seen = &desk.log().seen[before..];
    let resets = seen.iter().any(|(_, s)| *s == LoggedEvent::Reset);
    assert!(resets, "{seen:?}");
    let rises = seen.iter().any(|(_, s)| *s == LoggedEvent::Permit(true));
    assert!(!rises, "PERMIT rose, and nobody had armed it");
    assert!(!desk.status().permit);
}

/// The board reaches `mode` and stays there: keeps the addresses of bytes that hold it.
fn rests(desk: &mut Desk, processor: &CoreBits, mode: Mode) {
    while desk.step().mode() != Some(mode) {}
    for _ in 0..40 {
        desk.step();
    }
    processor.holds(mode as u8);
    for _ in 0..40 {
        assert_eq!(desk.step().mode(), Some(mode));
    }
}

/// The loop's mode is among the bytes that have held each mode in turn; the others are in the records of the last steps. If a
/// bit of it flips, the loop believes that it is running.
#[test]
fn a_loop_that_says_it_runs_by_a_wrong_bit_has_no_permission() {
    let firmware = Firmware::read(image()).expect("an image");
    let processor = CoreBits::default();
    // The first test is placed in the spare slot.
    let places = ["5SPARE", "7CONTROL"].map(|part| firmware.variable(part).expect("the loop"));
    processor.seek(places);
    let mut desk = Desk::with(Bench {
        firmware: Some(firmware),
        processor: Some(processor.clone()),
        ..Bench::default()
    });
    desk.load();
    rests(&mut desk, &processor, Mode::Idle);
    desk.order(Command::Event(Event::Arm));
    rests(&mut desk, &processor, Mode::Armed);
    desk.order(Command::Event(Event::Start));
    rests(&mut desk, &processor, Mode::Running);
    desk.order(Command::Event(Event::Hold));
    rests(&mut desk, &processor, Mode::Holding);
    desk.order(Command::Event(Event::Stop));
    rests(&mut desk, &processor, Mode::Finished);
    desk.order(Command::Event(Event::Clear));
    rests(&mut desk, &processor, Mode::Idle);

    let before = desk.log().seen.len();
    let mut runs = false;
    for address in processor.sought() {
        // From idle (0) to running (2).
        processor.turn_over_byte(address, 1);
        for _ in 0..60 {
            runs |= desk.step().mode() == Some(Mode::Running);
        }
    }
    assert!(runs, "{:x?}", processor.sought());
    let seen = &desk.log().seen[before..];
    let rises = seen.iter().any(|(_, s)| *s == LoggedEvent::Permit(true));
    assert!(!rises, "PERMIT rose, and nobody had armed it");
    assert!(!desk.status().permit);
}

/// A board whose control interrupt's memory is searched.
fn searched() -> (Desk, CoreBits) {
    let firmware = Firmware::read(image()).expect("an image");
    let processor = CoreBits::default();
    processor.seek(firmware.variable("7CONTROL"));
    let mut desk = Desk::with(Bench {
        firmware: Some(firmware),
        processor: Some(processor.clone()),
        ..Bench::default()
    });
    for _ in 0..40 {
        desk.step();
    }
    (desk, processor)
}

/// Keeps the addresses that now hold `byte`.
fn holds(desk: &mut Desk, processor: &CoreBits, byte: u8) {
    for _ in 0..40 {
        desk.step();
    }
    processor.holds(byte);
    for _ in 0..40 {
        desk.step();
    }
}

/// Flips `bit` of a byte in a running test, which must trip before this moves the command.
fn trips_at_once(desk: &mut Desk, processor: &CoreBits, address: u64, bit: u32) {
    desk.start();
    desk.until(Mode::Running);
    for _ in 0..100 {
        assert_eq!(desk.step().mode(), Some(Mode::Running));
    }
    let before = desk.log().seen.len();
    processor.turn_over_byte(address, bit);
    for _ in 0..100 {
        desk.step();
    }
    let status = desk.status();
    assert_eq!(status.trip.map(|t| t.fault), Some(Fault::Memory));
    assert!(!status.permit);
    let seen = desk.log().seen;
    let commands = seen[before - 20..].iter().filter_map(|(_, s)| match s {
        LoggedEvent::Command(code) => Some(*code),
        _ => None,
    });
    let commands: Vec<u16> = commands.collect();
    let steps = commands.windows(2).map(|w| w[1].abs_diff(w[0]));
    assert!(steps.max().expect("commands") < 40, "{commands:?}");
    desk.order(Command::Event(Event::Clear));
}

// proves: fault.memory by turn_over_byte
#[test]
fn a_wrong_bit_in_a_calibration_trips_before_a_command_is_sent_by_it() {
    let (mut desk, processor) = searched();
    for zero_code in [32_767.5_f32, 32_700.0, 32_640.0] {
        let mut calibration = Calibration::nominal(&codes());
        calibration.command.zero_code = zero_code;
        desk.order(Command::Calibrate(0, calibration));
        holds(&mut desk, &processor, zero_code.to_le_bytes()[1]);
    }
    let copies = processor.sought();
    assert_eq!(copies.len(), 2, "{copies:x?}");
    // Bit 23 of the number: an error of half the stroke.
    for address in copies {
        trips_at_once(&mut desk, &processor, address + 1, 7);
    }
}

/// Eight more points of the ground motion in each step would end the earthquake at once.
#[test]
fn a_wrong_bit_in_the_pace_of_the_ground_motion_trips() {
    let (mut desk, processor) = searched();
    desk.load();
    for interval_s in [0.01, 0.02, 0.005, 0.04] {
        desk.order(Command::Motion {
            points: 2,
            interval_s,
            checksum: checksum([0; 8]),
        });
        desk.order(Command::Points {
            first: 0,
            points: [0.0; 2].into_iter().collect(),
        });
        // Points per step, times 2^32, is what is stored.
        let points_a_step = 0.0005 / interval_s * 4_294_967_296.0;
        holds(
            &mut desk,
            &processor,
            (points_a_step as u32).to_le_bytes()[3],
        );
    }
    let copies = processor.sought();
    assert_eq!(copies.len(), 2, "{copies:x?}");
    for address in copies {
        trips_at_once(&mut desk, &processor, address + 1, 3);
    }
}
