//! Contents of the flash, and what a board does with a test that it finds there or is sent: whatever it accepts runs without a
//! panic, and every command is finite.
#![no_main]

use firmware::sim::{CLOCK, CODES};
use firmware::station::{AnyLoop, FlashRecord, Setup, Wiring};
use fuzz::begin_with;
use libfuzzer_sys::fuzz_target;
use link::command::BoardTest;
use link::frame::checksum;
use outerloop_core::{Config, Event, GroundMotion, Mode, OuterLoop, Rig, Sample};

fuzz_target!(
    init: begin_with(seeds()),
    |bytes: &[u8]| {
        let _ = (BoardTest::decode(bytes), Wiring::decode(bytes));
        if let Some((_, test)) = BoardTest::decode(&slot(BoardTest::KIND, bytes)) {
            as_configured(&test);
        }
        if let Some((sequence, wiring)) = Wiring::decode(&slot(Wiring::KIND, bytes)) {
            let kept = wiring.encode(sequence).expect("it came from a slot");
            assert_eq!(kept[..10], slot(Wiring::KIND, bytes)[..10]);
            let _ = (wiring.of(&CODES, 1), wiring.calibration.number());
        }
    }
);

/// A slot with this body and the right checksum.
fn slot(kind: [u8; 4], body: &[u8]) -> Vec<u8> {
    let length = u16::try_from(body.len()).unwrap_or(u16::MAX);
    let body = &body[..usize::from(length)];
    let mut slot = [&kind[..], &[7, 0, 0, 0], &length.to_le_bytes(), body].concat();
    let sum = checksum(slot.iter().copied());
    slot.extend_from_slice(&sum.to_le_bytes());
    slot
}

fn as_configured(test: &BoardTest) {
    let config = &test.config;
    for actuators in 1..=link::MAX_ACTUATORS {
        let mut setup = Setup::unconfigured(&CLOCK, actuators).expect("the clock allows 2 kHz");
        if setup.replace(test, &CLOCK, actuators).is_err() {
            continue;
        }
        match setup.outer {
            AnyLoop::One(outer) => runs(config, outer),
            AnyLoop::Two(outer) => runs(config, outer),
            AnyLoop::Three(outer) => runs(config, outer),
            AnyLoop::Coupled(outer) => runs(config, outer),
        }
    }
}

/// Runs a test with actuators that follow their commands one step later, against springs.
fn runs<const N: usize, R: Rig<N>>(config: &Config, mut outer: OuterLoop<N, R>) {
    let points: Vec<f32> = (0..40).map(|i| (i as f32 * 0.7).sin()).collect();
    let Some(ground) = GroundMotion::new(&points, 0.01, config.model_step_s()) else {
        return;
    };
    let mut position_m = [0.0; N];
    let mut step = |outer: &mut OuterLoop<N, R>| {
        let sample = Sample::new(position_m, position_m.map(|u| 1e5 * u));
        position_m = outer.step(&sample, &ground).command_m;
        assert!(position_m.iter().all(|u| u.is_finite()), "{position_m:?}");
    };
    step(&mut outer);
    let _ = outer.handle(Event::Arm);
    for _ in 0..8 {
        step(&mut outer);
    }
    let _ = outer.handle(Event::Start);
    for _ in 0..60 {
        step(&mut outer);
    }
    let _ = outer.handle(Event::Stop);
    for _ in 0..8 {
        step(&mut outer);
    }
    if outer.mode() == Mode::Tripped {
        outer.handle(Event::Clear).expect("a trip can be cleared");
        step(&mut outer);
    }
}

/// Bodies of slots.
fn seeds() -> Vec<Vec<u8>> {
    let body =
        |slot: &[u8]| slot[10..10 + usize::from(u16::from_le_bytes([slot[8], slot[9]]))].to_vec();
    let mut coupled = Config::shear_frame([1e3; 3], [158e3; 3], [0.02; 3]);
    coupled.structure.physical_storeys = Some(1);
    let calibration = link::Calibration::over(0.1, 1e4, &CODES);
    let wiring = Wiring::new(calibration, &CODES, 1).encode(0);
    let tests = [Config::shear_frame([1e3], [158e3], [0.02]), coupled].map(BoardTest::from);
    let mut seeds: Vec<_> = tests
        .iter()
        .map(|test| body(&test.encode(0).expect("it fits")))
        .collect();
    seeds.push(body(&wiring.expect("it fits")));
    seeds
}
