//! Settings that were saved before the power was off. The emulator drops writes to the flash, so they are placed there.

use crate::desk::{Desk, config, image};
use emu::Firmware;
use emu::nucleo::RIGHT_CRYSTAL_HZ;
use firmware::station::{SETTINGS_BYTES, Settings};
use link::channel::Calibration;
use link::command::Command;
use link::reply::Reply;
use link::status::Timing;
use outerloop_core::{Config, Event, State};

/// The last sector of the flash, a row of slots.
const SECTOR: u64 = 0x081e_0000;
const SLOT: u64 = 1024;

/// Cycles of a period at 1 and at 2 kHz.
const AT_1_KHZ: u32 = 168_000;
const AT_2_KHZ: u32 = 84_000;

fn saved(config: Config) -> Vec<u8> {
    let mut bytes = [0; SETTINGS_BYTES];
    let settings = Settings {
        config,
        calibration: Calibration::UNCALIBRATED,
    };
    settings.encode(&mut bytes).unwrap();
    bytes.to_vec()
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
        firmware = firmware.with_flash(SECTOR + slot * SLOT, bytes).unwrap();
    }
    let mut desk = Desk::with_firmware(firmware, RIGHT_CRYSTAL_HZ, None);
    let status = desk.status();
    let Timing { period_cycles, .. } = status.timing;
    (desk, status.configured, period_cycles)
}

#[test]
fn the_settings_that_were_saved_last_are_in_force_at_power_up() {
    let (mut desk, configured, period) = power_on(vec![saved(config()), saved(at_1_khz())]);
    assert!(configured);
    assert_eq!(period, AT_1_KHZ);
    // A ground motion is not saved: a test cannot begin by itself.
    desk.pc.forget_steps();
    let reply = desk.ask(Command::Event(Event::Arm));
    assert!(matches!(reply, Reply::Rejected { .. }), "{reply:?}");
    assert_eq!(desk.status().state, State::Idle);
}

#[test]
fn a_slot_that_the_power_failed_in_is_passed_over() {
    let mut torn = saved(config());
    torn[100..].fill(0xff);
    let (_desk, configured, period) = power_on(vec![saved(at_1_khz()), torn.clone()]);
    assert!(configured);
    assert_eq!(period, AT_1_KHZ);

    let (_desk, configured, period) = power_on(vec![torn]);
    assert!(!configured);
    assert_eq!(period, AT_2_KHZ);
}
