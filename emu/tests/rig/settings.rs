//! Settings that are saved, and those that were saved before a power-down.

use crate::desk::{Bench, Desk, codes, config, image};
use emu::{Firmware, InjectedFault, PlannedFault};
use firmware::station::{FlashRecord, Wiring};
use link::Calibration;
use link::command::{BoardTest, Command};
use link::reply::{Obstacle, Reply};
use link::status::Timing;
use outerloop_core::{Config, Event, Mode};

/// Addresses of tests and calibrations, which are rows of slots.
const TESTS: u64 = 0x081c_0000;
const TEST_SLOT: u64 = 2048;
const SLOTS: u32 = 64;
const CALIBRATIONS: u64 = 0x0810_0000;

/// Cycles of a period at 1 and at 2 kHz.
const AT_1_KHZ: u32 = 168_000;
const AT_2_KHZ: u32 = 84_000;

fn saved(sequence: u32, config: Config) -> Vec<u8> {
    BoardTest::from(config).encode(sequence).unwrap().to_vec()
}

fn at_1_khz() -> Config {
    let mut config = config();
    config.timing.rate_hz = 1000.0;
    config
}

/// Largest deviation of a period, cycles.
const PERIOD_OFF_CYCLES: u32 = 100;

/// Power on, with these bytes in the flash. The board is reset after 100 steps with PERMIT.
fn reset_when_armed(left: impl IntoIterator<Item = (u64, Vec<u8>)>) -> Desk {
    let mut firmware = Firmware::read(image()).unwrap();
    for (address, bytes) in left {
        firmware = firmware.with_flash(address, bytes).unwrap();
    }
    Desk::with(Bench {
        firmware: Some(firmware),
        plan: Some(PlannedFault {
            after_steps: 100,
            fault: InjectedFault::Reset,
        }),
        ..Bench::default()
    })
}

/// Arms the board, and waits until it has been reset.
fn reset(desk: &mut Desk) {
    desk.pc.forget_steps();
    for _ in 0..300 {
        desk.step();
    }
    desk.order(Command::Event(Event::Arm));
    desk.until_reset();
}

// proves: command.save
#[test]
fn what_is_saved_is_in_force_after_a_reset() {
    let mut desk = reset_when_armed([]);
    desk.load();
    let other = Calibration::over(0.05, 12e3, &codes());
    desk.order(Command::Calibrate(0, other));
    desk.order(Command::Save);
    reset(&mut desk);
    let status = desk.status();
    assert!(status.calibrated && status.configured && !status.permit);
    let Reply::Identity(identity) = desk.ask(Command::Identify) else {
        panic!("no identity");
    };
    assert_eq!(identity.calibration.number(), other.number());
}

/// The next sector holds what an older program left there: it is erased first, which takes seconds.
#[test]
fn a_sector_is_erased_when_the_other_is_full_and_the_board_keeps_its_period() {
    let full = (0..SLOTS).map(|slot| {
        let address = TESTS + u64::from(slot) * TEST_SLOT;
        (address, saved(slot, at_1_khz()))
    });
    let other = TESTS + u64::from(SLOTS) * TEST_SLOT;
    let left = vec![0; SLOTS as usize * TEST_SLOT as usize];
    let mut desk = reset_when_armed(full.chain([(other, left)]));
    assert_eq!(desk.status().timing.period_cycles, AT_1_KHZ);
    desk.load();
    // The period in which the rate changed has neither length: times count from here on.
    desk.order(Command::Configure(config().into()));
    let before = desk.log().periods;
    desk.order(Command::Save);
    let lasted = desk.log().periods - before;
    let status = desk.status();
    let timing = status.timing;
    let (short, long) = (timing.shortest_period_cycles, timing.longest_period_cycles);
    println!("{short} to {long} cycles, {lasted} periods");
    // By the data sheet 2 s for 128 KiB, a byte at a time.
    assert!(lasted > 4000);
    let off = short.abs_diff(AT_2_KHZ).max(long.abs_diff(AT_2_KHZ));
    assert!(off <= PERIOD_OFF_CYCLES);
    assert_eq!((timing.overruns, status.dropped_steps), (0, 0));
    assert!(!desk.log().permitted.contains(&true));
    reset(&mut desk);
    let status = desk.status();
    assert!(status.configured);
    assert_eq!(status.timing.period_cycles, AT_2_KHZ);
}

/// Power on, with these slots filled. Returns whether the board then has a test, and its period.
fn power_on(slots: Vec<Vec<u8>>) -> (Desk, bool, u32) {
    let mut firmware = Firmware::read(image()).unwrap();
    for (slot, bytes) in (0..).zip(slots) {
        firmware = firmware
            .with_flash(TESTS + slot * TEST_SLOT, bytes)
            .unwrap();
    }
    let mut desk = Desk::with(Bench {
        firmware: Some(firmware),
        ..Bench::default()
    });
    let status = desk.status();
    let Timing { period_cycles, .. } = status.timing;
    (desk, status.configured, period_cycles)
}

#[test]
fn the_settings_that_were_saved_last_are_in_force_at_power_up() {
    let (mut desk, configured, period) = power_on(vec![saved(1, config()), saved(2, at_1_khz())]);
    assert!(configured);
    assert_eq!(period, AT_1_KHZ);
    // A ground motion is not saved: a test cannot begin by itself.
    desk.pc.forget_steps();
    let reply = desk.ask(Command::Event(Event::Arm));
    assert!(matches!(reply, Reply::Rejected { .. }), "{reply:?}");
    assert_eq!(desk.status().mode, Mode::Idle);
}

#[test]
fn a_slot_that_the_power_failed_in_is_passed_over() {
    let mut torn = saved(2, config());
    torn[100..].fill(0xff);
    let (_desk, configured, period) = power_on(vec![saved(1, at_1_khz()), torn.clone()]);
    assert!(configured);
    assert_eq!(period, AT_1_KHZ);

    let (_desk, configured, period) = power_on(vec![torn]);
    assert!(!configured);
    assert_eq!(period, AT_2_KHZ);
}

#[test]
fn the_calibration_that_was_saved_is_in_force_without_a_test() {
    let half = Calibration::over(0.025, 5e3, &codes());
    let kept = Wiring::new(half, &codes(), 1).encode(1).unwrap();
    let firmware = Firmware::read(image()).unwrap();
    let firmware = firmware.with_flash(CALIBRATIONS, kept.to_vec()).unwrap();
    let mut desk = Desk::with(Bench {
        firmware: Some(firmware),
        ..Bench::default()
    });
    let status = desk.status();
    assert!(status.calibrated && !status.configured);
    let Reply::Identity(identity) = desk.ask(Command::Identify) else {
        panic!("no identity");
    };
    assert_eq!(identity.calibration.number(), half.number());
}

#[test]
fn what_a_board_goes_by_that_nobody_has_calibrated_takes_its_calibration_back() {
    let mut desk = Desk::new(None);
    desk.load();
    let placeholder = Calibration::placeholder(&codes());
    desk.order(Command::Calibrate(0, placeholder));
    let reply = desk.ask(Command::Event(Event::Arm));
    let obstacle = Some(Obstacle::NotCalibrated);
    assert!(
        matches!(reply, Reply::Rejected { obstacle: o, .. } if o == obstacle),
        "{reply:?}"
    );
}
