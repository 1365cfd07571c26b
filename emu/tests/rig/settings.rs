//! Settings that were saved before the power was off. The emulator drops writes to the flash, so they are placed there.

use crate::desk::{Bench, Desk, codes, config, image};
use emu::Firmware;
use firmware::station::{FlashRecord, Wiring};
use link::Calibration;
use link::command::Command;
use link::reply::{Obstacle, Reply};
use link::status::Timing;
use outerloop_core::{Config, Event, Mode};

/// Where tests and calibrations are, rows of slots.
const TESTS: u64 = 0x081c_0000;
const TEST_SLOT: u64 = 1024;
const CALIBRATIONS: u64 = 0x0810_0000;

/// Cycles of a period at 1 and at 2 kHz.
const AT_1_KHZ: u32 = 168_000;
const AT_2_KHZ: u32 = 84_000;

fn saved(sequence: u32, config: Config) -> Vec<u8> {
    config.encode(sequence).unwrap().to_vec()
}

fn at_1_khz() -> Config {
    let mut config = config();
    config.timing.rate_hz = 1000.0;
    config
}

/// Power on, with these slots filled. Gives whether the board has a test then, and its period.
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
    assert_eq!(desk.status().state, Mode::Idle);
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
    let kept = Wiring::new(half, &codes()).encode(1).unwrap();
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
