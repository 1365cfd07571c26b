//! How a test comes to a standstill, and how it comes to its start: ramps, and what disturbs them.
#![allow(missing_docs)]

mod common;

use common::{Rig, ground, shaking, started, stopping_and_going, table1};
use outerloop_core::{
    Design, Event, Fault, GroundMotion, Method, Mode, OBSTACLE_STEPS, OuterLoop, Prediction,
    Sample, flag,
};

const RECORD_S: f64 = 6.0;

#[test]
fn a_ramp_that_would_not_end_soon_is_none() {
    let points = shaking(RECORD_S);
    for (deceleration, ramps) in [(0.1, true), (0.01, false)] {
        let mut config = table1();
        config.timing.hold_deceleration_m_per_s2 = deceleration;
        let mut rig = Rig::new(8);
        let mut outer = started(&config, &mut rig, &ground(&points));
        let (mut speed, mut steps) = (0.0_f32, 0);
        // 0.04 to 0.2 m/s: of the first it takes 2 s at most, of the second 4 at least.
        while !(2e-5..1e-4).contains(&speed) || steps < 1000 {
            let before = rig.sent;
            rig.step(&mut outer, &ground(&points));
            (speed, steps) = ((rig.sent - before).abs(), steps + 1);
        }
        let mut sample = rig.sample();
        sample.fault = Some(Fault::LinkLost);
        let step = outer.step(&sample, &ground(&points));
        assert_eq!(step.permit, ramps, "{deceleration} m/s^2");
        assert_eq!(outer.trip().map(|t| t.fault), Some(Fault::LinkLost));
    }
}

/// However gentle a ramp is asked for, and wherever the motion is: it ends before the limit on displacement.
#[test]
fn a_stop_ends_inside_the_limit_on_displacement_whatever_the_deceleration() {
    let points = shaking(RECORD_S);
    let mut rig = Rig::new(8);
    let mut outer = started(&table1(), &mut rig, &ground(&points));
    let peak_m = (0..8000).fold(0.0_f32, |peak, _| {
        rig.step(&mut outer, &ground(&points));
        peak.max(rig.sent.abs())
    });
    let limit_m = 1.2 * f64::from(peak_m);
    let mut shortened = 0;
    for deceleration in [0.05, 1.0, 5.0] {
        for stopped_at in (2000..8000).step_by(500) {
            let mut config = table1();
            config.limits.displacement_m = Some(limit_m);
            config.timing.hold_deceleration_m_per_s2 = deceleration;
            let mut rig = Rig::new(8);
            let mut outer = started(&config, &mut rig, &ground(&points));
            let mut before = 0.0;
            for _ in 0..stopped_at {
                before = rig.sent;
                rig.step(&mut outer, &ground(&points));
            }
            assert_eq!(outer.mode(), Mode::Running);
            let speed = f64::from(rig.sent - before) * 2000.0;
            let way_m = speed * speed.abs() / (2.0 * deceleration);
            shortened += u32::from((f64::from(rig.sent) + way_m).abs() > limit_m);
            outer.handle(Event::Stop).unwrap();
            let mut still = 0;
            while still < 100 {
                before = rig.sent;
                rig.step(&mut outer, &ground(&points));
                still = if rig.sent == before { still + 1 } else { 0 };
                assert!(f64::from(rig.sent.abs()) < limit_m, "{} m", rig.sent);
            }
            let said = format!(
                "{deceleration} m/s^2, step {stopped_at}: {:?}",
                outer.trip()
            );
            assert_eq!(outer.mode(), Mode::Finished, "{said}");
        }
    }
    assert!(shortened > 10, "{shortened} ramps had to be shorter");
}

/// Slow as well: the mean over the last readings that is held is over a time and not over a number of them.
#[test]
fn a_rig_that_sinks_is_armed_where_it_is_at_any_rate() {
    for rate_hz in [100.0, 200.0, 500.0, 1000.0, 2000.0] {
        let mut config = table1();
        config.timing.rate_hz = rate_hz;
        let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
        let (mut at_m, none) = (0.02, GroundMotion::none());
        for _ in 0..(2.0 * rate_hz) as u32 {
            at_m -= (0.005 / rate_hz) as f32;
            outer.step(&Sample::new([at_m], [0.0]), &none);
        }
        let held_m = outer.step(&Sample::new([at_m], [0.0]), &none).command_m[0];
        assert!(
            (held_m - at_m).abs() < 4e-4,
            "{rate_hz} Hz: {held_m} of {at_m} m"
        );
    }
}

#[test]
fn a_contact_that_bounces_on_the_way_to_the_start_moves_nothing_back() {
    let mut config = table1();
    config.limits.velocity_m_per_s = Some(0.05);
    let none = GroundMotion::none();
    let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
    let mut at_m = 0.02_f32;
    let sample = |at_m: f32, chain_open: bool| Sample {
        chain_open,
        ..Sample::new([at_m], [0.0])
    };
    for _ in 0..300 {
        outer.step(&sample(at_m, false), &none);
    }
    outer.handle(Event::Arm).unwrap();
    // The contact closes after a while, and until then the piston sinks by a millimetre, which is followed.
    for _ in 0..1000 {
        at_m -= 1e-6;
        outer.step(&sample(at_m, true), &none);
    }
    let followed = outer.step(&sample(at_m, true), &none).command_m[0];
    assert!((followed - at_m).abs() < 1e-4, "{followed} of {at_m} m");
    let mut bounced = 0;
    for n in 0..20_000 {
        let open = n % 1000 < 3 && n > 0;
        let step = outer.step(&sample(at_m, open), &none);
        bounced += u32::from(step.record.has(flag::CHAIN_OPEN));
        // 2 mm/s are 1 um a step.
        let moved = step.command_m[0] - at_m;
        assert!(n == 0 || moved.abs() < 1.01e-6, "{moved} m in step {n}");
        at_m = step.command_m[0];
    }
    assert_eq!((outer.mode(), outer.trip()), (Mode::Armed, None));
    assert!(bounced > 20, "{bounced}");
}

#[test]
fn stop_and_go_ends_on_the_ramp_whatever_predicts_beside_it() {
    for method in [Method::Paper, Method::Inverse] {
        let mut config = table1();
        config.compensation.kind = method;
        config.compensation.delay_ms = 4.0.into();
        config.timing.approach_m_per_s = 0.2;
        let mut rig = Rig::new(8);
        let mut outer = stopping_and_going(&config, &mut rig);
        let none = GroundMotion::none();
        outer.set_next_target([0.05]);
        for _ in 0..200 {
            rig.step(&mut outer, &none);
        }
        let before = rig.sent;
        outer.handle(Event::Stop).unwrap();
        for _ in 0..1000 {
            rig.step(&mut outer, &none);
        }
        // v^2 / 2a of 0.2 m/s at 5 m/s^2.
        let way_m = rig.sent - before;
        assert!((way_m - 0.004).abs() < 2e-4, "{method:?}: {way_m} m");
    }
}

/// The delay line that brings displacement and force to one instant begins where the rig stands.
#[test]
fn a_force_that_is_read_late_or_early_does_not_move_the_start() {
    for late_ms in [3.0, -3.0] {
        let mut config = table1();
        config.rig.force_late_ms = [late_ms].into_iter().collect();
        config.limits.tracking_m = Some(0.005);
        let none = GroundMotion::none();
        let mut outer = OuterLoop::<1>::new(Design::new(&config).unwrap());
        let standing = Sample::new([0.02], [3160.0]);
        for _ in 0..2 * OBSTACLE_STEPS {
            outer.step(&standing, &none);
        }
        outer.handle(Event::Arm).unwrap();
        for _ in 0..20 {
            let record = *outer.step(&standing, &none).record;
            assert_eq!(outer.trip(), None, "{late_ms} ms");
            assert!((record.displacement_m[0] - 0.02).abs() < 1e-6);
            assert!((record.force_n[0] - 3160.0).abs() < 1.0);
        }
    }
}

/// Noise of the force reaches the command behind these predictors, and its change from one step to the next is no speed.
#[test]
fn the_ramp_to_a_hold_is_as_long_whatever_noise_a_predictor_hands_on() {
    let points = shaking(RECORD_S);
    for predictor in [Prediction::Hydraulic, Prediction::Afp] {
        let mut config = table1();
        config.compensation.kind = Method::None.behind(predictor);
        config.compensation.delay_ms = 20.0.into();
        let ways = [1_u32, 2, 3, 4, 5].map(|seed| {
            let mut rig = Rig::new(40);
            let mut outer = started(&config, &mut rig, &ground(&points));
            let mut rng = seed;
            for _ in 0..4000 {
                let mut sample = rig.sample();
                rng = rng.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                // 100 N rms.
                sample.force_n[0] += 173.0 * ((rng >> 8) as f32 / 8_388_608.0 - 1.0);
                rig.sent = outer.step(&sample, &ground(&points)).command_m[0];
            }
            let from = rig.sent;
            outer.handle(Event::Hold).unwrap();
            for _ in 0..4000 {
                rig.step(&mut outer, &ground(&points));
            }
            assert_eq!(outer.mode(), Mode::Holding);
            rig.sent - from
        });
        let (least, most) = (
            ways.iter().copied().reduce(f32::min),
            ways.iter().copied().reduce(f32::max),
        );
        let apart = most.unwrap() - least.unwrap();
        println!("{predictor:?}: {ways:?}");
        assert!(apart < 3e-3, "{predictor:?}: {apart} m apart of {ways:?}");
    }
}

/// While the prediction comes back by and by, what is not sent yet is taken for no delay.
#[test]
fn nothing_is_learnt_on_the_way_back_from_a_hold() {
    let points = shaking(RECORD_S);
    let mut config = table1();
    config.compensation.kind = Method::None.behind(Prediction::Afp);
    config.compensation.delay_ms = 30.0.into();
    config.timing.approach_m_per_s = 0.2;
    let mut rig = Rig::new(60);
    let mut outer = started(&config, &mut rig, &ground(&points));
    let (mut before_m, mut behind_m, mut ran) = (0.0_f32, 0.0_f32, 0);
    for i in 0..12_000 {
        match i {
            5000 => drop(outer.handle(Event::Hold).unwrap()),
            7000 => drop(outer.handle(Event::Start).unwrap()),
            _ => {}
        }
        let record = rig.step(&mut outer, &ground(&points)).record;
        let off_m = (record.displacement_m[0] - record.command_m[0]).abs();
        match (i, outer.mode()) {
            (2000..5000, _) => before_m = before_m.max(off_m),
            (7000.., Mode::Running) if ran < 1000 => {
                ran += 1;
                behind_m = behind_m.max(off_m);
            }
            _ => {}
        }
    }
    println!("{before_m} m before the hold, {behind_m} m behind it");
    // 7.9 mm where it learns.
    assert!(
        ran == 1000 && before_m < 1e-4 && behind_m < 2e-3,
        "{behind_m}"
    );
}
