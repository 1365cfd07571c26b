//! No bit pattern in a sample, at any moment and in any state, ever yields a command that is not finite.
#![allow(missing_docs)]

mod common;

use common::{Rig, shaking, started, table1};
use outerloop_core::{
    Design, Event, Fault, GroundMotion, Method, Mode, OuterLoop, Sample, config::Filter,
};
use proptest::prelude::*;

fn any_f32() -> impl Strategy<Value = f32> {
    prop_oneof![
        any::<u32>().prop_map(f32::from_bits),
        Just(f32::NAN),
        Just(f32::INFINITY),
        Just(f32::MAX),
        Just(f32::MIN_POSITIVE / 4.0),
        -0.1_f32..0.1,
    ]
}

fn any_method() -> impl Strategy<Value = Method> {
    prop::sample::select(&Method::ALL[..])
}

fn any_filter() -> impl Strategy<Value = Filter> {
    prop::sample::select(&[Filter::Off, Filter::Kalman, Filter::LowPass][..])
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn every_command_is_finite(
        bad in prop::collection::vec((any_f32(), any_f32(), any::<bool>()), 1..40),
        quiet in 0_usize..60,
        method in any_method(),
        filter in any_filter(),
        substeps in 1_u16..5,
    ) {
        let points = shaking(2.0);
        let mut config = table1();
        config.compensation.kind = method;
        config.estimation.kind = filter;
        config.timing.substeps = substeps;
        let ground = GroundMotion::new(&points, 0.01, config.model_step_s()).unwrap();
        let mut rig = Rig::new(3);
        let mut outer = started(&config, &mut rig, &ground);
        for _ in 0..quiet {
            prop_assert!(rig.step(&mut outer, &ground).command_m[0].is_finite());
        }
        for (u, r, fresh) in bad {
            let sample = Sample { fresh, ..Sample::new([u], [r]) };
            let live = outer.mode().permits_motion();
            let step = outer.step(&sample, &ground);
            prop_assert!(step.command_m[0].is_finite(), "{:?}", step.record);
            if live && !(u.is_finite() && r.is_finite()) {
                prop_assert_eq!(outer.mode(), Mode::Tripped);
            }
            // Whatever happened, it must be possible to go on from it.
            if outer.mode() == Mode::Tripped {
                outer.handle(Event::Clear).unwrap();
                prop_assert!(outer.step(&sample, &ground).command_m[0].is_finite());
                let _ = outer.handle(Event::Arm);
            }
        }
    }

    #[test]
    fn an_idle_loop_survives_anything_and_can_be_armed_afterwards(
        bad in prop::collection::vec((any_f32(), any_f32()), 1..20),
    ) {
        let mut config = table1();
        config.limits.displacement_m = Some(0.2);
        let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
        let ground = GroundMotion::none();
        for (u, r) in bad {
            prop_assert!(outer.step(&Sample::new([u], [r]), &ground).command_m[0].is_finite());
            prop_assert_eq!(outer.mode(), Mode::Idle);
        }
        for _ in 0..20_000 {
            outer.step(&Sample::new([0.01], [0.0]), &ground);
        }
        prop_assert!(outer.handle(Event::Arm).is_ok());
    }
}

/// Every exponent, both signs, a few mantissas and every NaN class: the whole range, not a sample of it.
// proves: fault.non_finite
#[test]
fn a_sweep_over_all_exponents() {
    let points = shaking(1.0);
    let ground = GroundMotion::new(&points, 0.01, 5e-4).unwrap();
    for high in 0..=0x1ff_u32 {
        for mantissa in [0, 1, 0x3f_ffff, 0x40_0000, 0x7f_ffff] {
            let x = f32::from_bits(high << 23 | mantissa);
            for place in 0..2 {
                let mut rig = Rig::new(2);
                let mut outer = started(&table1(), &mut rig, &ground);
                for _ in 0..10 {
                    rig.step(&mut outer, &ground);
                }
                let mut sample = rig.sample();
                if place == 0 {
                    sample.displacement_m = [x];
                } else {
                    sample.force_n = [x];
                }
                for _ in 0..3 {
                    assert!(
                        outer.step(&sample, &ground).command_m[0].is_finite(),
                        "{x:e}"
                    );
                }
                if !x.is_finite() {
                    assert_eq!(outer.trip().map(|t| t.fault), Some(Fault::NonFinite));
                }
            }
        }
    }
}
