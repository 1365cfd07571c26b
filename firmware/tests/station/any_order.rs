//! Commands in any order: whatever was asked before, a test can be loaded, armed and run.

use crate::common::{Bench, bench, config, pulse};
use firmware::sim::CODES;
use link::Calibration;
use link::command::{Channel, Command, CommissioningSignal, SignalShape};
use link::frame::checksum;
use link::reply::Reply;
use outerloop_core::{Event, Mode, Pace};
use proptest::prelude::*;

fn command() -> impl Strategy<Value = Command> {
    let points = || {
        (0_u32..400, 0_usize..129).prop_map(|(first, count)| Command::Points {
            first,
            points: pulse().into_iter().cycle().take(count.min(128)).collect(),
        })
    };
    let motion = (
        0_u32..300,
        prop_oneof![Just(0.01), Just(0.0), Just(1e-9)],
        any::<bool>(),
    )
        .prop_map(|(points, interval_s, right)| {
            let sum = checksum(
                pulse()
                    .iter()
                    .cycle()
                    .take(points as usize)
                    .flat_map(|p| p.to_le_bytes()),
            );
            Command::Motion {
                points,
                interval_s,
                checksum: if right { sum } else { !sum },
            }
        });
    prop_oneof![
        3 => points(),
        3 => motion,
        1 => Just(Command::Identify),
        1 => Just(Command::Status),
        1 => Just(Command::Configure(config().into())),
        1 => Just(Command::Calibrate(0, Calibration::nominal(&CODES))),
        1 => Just(Command::Zero { actuator: 0, channel: Channel::Force, value: 0.0 }),
        1 => Just(Command::Save),
        1 => Just(Command::Signal(None)),
        1 => Just(Command::Signal(Some(CommissioningSignal { actuator: 0, shape: SignalShape::Constant, amplitude_m: 0.001, seconds: 1.0 }))),
        1 => (0_u8..20).prop_map(Command::History),
        1 => prop_oneof![Just(None), Just(Some(Pace::StopAndGo)), Just(Some(Pace::Continuous))].prop_map(Command::Pace),
        1 => prop_oneof![Just(0.002), Just(-1.0), Just(f32::NAN)].prop_map(|m| Command::Target([m].into_iter().collect())),
        3 => prop::sample::select(Event::ALL.to_vec()).prop_map(Command::Event),
    ]
}

/// Back to idle, whatever it does.
fn calm(b: &mut Bench) {
    for _ in 0..200_000 {
        match b.board.mode() {
            Mode::Idle => return,
            Mode::Finished | Mode::Tripped => drop(b.event(Event::Clear)),
            _ => drop(b.event(Event::Stop)),
        }
        for _ in 0..20 {
            b.step();
        }
    }
    panic!("it never ends");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    // proves: command.points, command.motion
    #[test]
    fn a_test_can_always_be_loaded_and_started(commands in proptest::collection::vec((command(), 0_usize..30), 0..40)) {
        let mut b = bench();
        for (command, steps) in commands {
            let _ = b.ask(command);
            for _ in 0..steps {
                b.step();
            }
        }
        calm(&mut b);
        b.hardware.board.plant.position_m = 0.003;
        let calibrated = b.ask(Command::Calibrate(0, Calibration::nominal(&CODES)));
        prop_assert!(matches!(calibrated, Reply::Done { .. }), "{:?}", calibrated);
        b.ready(config(), &pulse());
        let started = b.event(Event::Start);
        prop_assert!(matches!(started, Reply::Done { mode: Mode::Running, .. }), "{:?}", started);
    }
}
