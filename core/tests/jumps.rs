//! Whatever comes, in whatever order: with PERMIT no command is further from the one before than the limit, without it nothing that
//! has tripped moves.
#![allow(missing_docs)]

mod common;

use common::{Rig, shaking, table1};
use outerloop_core::{
    Config, Design, Event, Fault, GroundMotion, Method, Mode, OuterLoop, Pace, Sample,
    config::Filter,
};
use proptest::prelude::*;
use proptest::test_runner::{RngAlgorithm, TestRng, TestRunner};
use std::cell::RefCell;

const STROKE_M: f32 = 0.1;
const INCREMENT_M: f32 = 1e-3;

/// Something that comes to the loop.
#[derive(Clone, Debug)]
enum Comes {
    Asked(Event),
    /// So many steps on a rig that does what it is told.
    Steps(u8),
    /// As many with the contact of the permission's chain open.
    Open(u8),
    /// A sample of any bits, fresh or not.
    Wild(f32, f32, bool),
    Reported(Fault),
    Target(f32),
    Paced(Option<Pace>),
    Commissioned(Option<f32>),
    Designed(Method, Filter, u16),
}

fn any_f32() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<u32>().prop_map(f32::from_bits),
        Just(f32::NAN),
        Just(f32::INFINITY),
        -0.2_f32..0.2,
    ]
}

fn comes() -> impl Strategy<Value = Comes> {
    let pace = prop::sample::select(&[None, Some(Pace::StopAndGo), Some(Pace::Continuous)][..]);
    let filter = prop::sample::select(&[Filter::Off, Filter::Kalman, Filter::LowPass][..]);
    prop_oneof![
        // In the order of a test more often than not.
        4 => prop::sample::select(&[Event::Arm, Event::Start, Event::Hold, Event::Clear][..]).prop_map(Comes::Asked),
        2 => prop::sample::select(&Event::ALL[..]).prop_map(Comes::Asked),
        8 => any::<u8>().prop_map(Comes::Steps),
        1 => (1_u8..20).prop_map(Comes::Open),
        1 => (any_f32(), any_f32(), any::<bool>()).prop_map(|(m, n, fresh)| Comes::Wild(m, n, fresh)),
        1 => prop::sample::select(&Fault::ALL[..]).prop_map(Comes::Reported),
        2 => (-0.02_f32..0.02).prop_map(Comes::Target),
        1 => pace.prop_map(Comes::Paced),
        1 => prop::option::of(prop_oneof![any_f32(), -5e-4_f32..5e-4]).prop_map(Comes::Commissioned),
        1 => (prop::sample::select(&Method::ALL[..]), filter, 1_u16..6)
            .prop_map(|(method, filter, substeps)| Comes::Designed(method, filter, substeps)),
    ]
}

fn limited() -> Config {
    let mut config = table1();
    config.limits.displacement_m = Some(f64::from(STROKE_M));
    config.limits.increment_m = Some(f64::from(INCREMENT_M));
    config.limits.stale_steps = Some(5);
    config
}

/// A loop with its rig, and what it said last.
struct Test<'a> {
    outer: OuterLoop<1>,
    rig: Rig,
    ground: GroundMotion<'a>,
    last_m: f32,
    reached: &'a RefCell<Vec<Mode>>,
}

impl Test<'_> {
    fn step(&mut self, sample: &Sample<1>) -> Result<(), TestCaseError> {
        let stood = (self.outer.mode() == Mode::Tripped).then_some(self.last_m);
        let step = self.outer.step(sample, &self.ground);
        let [command_m] = step.command_m;
        let (permit, mode) = (step.permit, self.outer.mode());
        let jump_m = (command_m - self.last_m).abs();
        prop_assert!(command_m.is_finite());
        prop_assert!(!permit || mode.permits_motion(), "PERMIT in {mode:?}");
        if permit {
            prop_assert!(jump_m <= INCREMENT_M, "{jump_m} m in {mode:?}");
            prop_assert!(command_m.abs() <= STROKE_M, "{command_m} m in {mode:?}");
        }
        if let (Some(stood), Mode::Tripped) = (stood, mode) {
            prop_assert_eq!(stood.to_bits(), command_m.to_bits());
        }
        (self.last_m, self.rig.sent) = (command_m, command_m);
        let mut reached = self.reached.borrow_mut();
        if !reached.contains(&mode) {
            reached.push(mode);
        }
        Ok(())
    }

    fn take(&mut self, what: &Comes) -> Result<(), TestCaseError> {
        match what {
            Comes::Asked(event) => drop(self.outer.handle(*event)),
            Comes::Steps(count) => {
                for _ in 0..*count {
                    let sample = self.rig.sample();
                    self.step(&sample)?;
                }
            }
            Comes::Open(count) => {
                for _ in 0..*count {
                    let open = Sample {
                        chain_open: true,
                        ..self.rig.sample()
                    };
                    self.step(&open)?;
                }
            }
            Comes::Wild(m, n, fresh) => {
                let wild = Sample::new([*m], [*n]);
                self.step(&Sample {
                    fresh: *fresh,
                    ..wild
                })?;
            }
            Comes::Reported(fault) => {
                let sound = self.rig.sample();
                self.step(&Sample {
                    fault: Some(*fault),
                    ..sound
                })?;
            }
            Comes::Target(m) => self.outer.set_next_target([*m]),
            Comes::Paced(pace) => self.outer.set_pace(*pace),
            Comes::Commissioned(m) => self.outer.set_commissioning_command(m.map(|m| [m])),
            Comes::Designed(method, filter, substeps) => {
                let mut config = limited();
                config.compensation.kind = *method;
                config.estimation.kind = *filter;
                config.timing.substeps = *substeps;
                // While a test runs it is refused.
                let _ = self.outer.configure(Design::new(&config).unwrap());
            }
        }
        Ok(())
    }
}

#[test]
fn with_permit_no_command_jumps_and_what_has_tripped_stands_whatever_comes() {
    let points = shaking(2.0);
    let config = limited();
    let reached = RefCell::new(Vec::new());
    let drawn = ProptestConfig {
        cases: 2000,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    // The same ones each time, so that what they reach is no chance.
    let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
    let mut runner = TestRunner::new_with_rng(drawn, rng);
    let sequences = prop::collection::vec(comes(), 1..60);
    let result = runner.run(&sequences, |sequence| {
        let mut test = Test {
            outer: OuterLoop::new(Design::new(&config).unwrap()),
            rig: Rig::new(3),
            ground: GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap(),
            last_m: 0.0,
            reached: &reached,
        };
        sequence.iter().try_for_each(|what| test.take(what))
    });
    result.unwrap();
    let reached = reached.into_inner();
    for mode in Mode::ALL {
        assert!(reached.contains(&mode), "{mode:?} was not reached");
    }
}
