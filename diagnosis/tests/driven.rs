//! Actuators of other equations than the library's, without a rest and in mid-motion from the first sample: what the
//! engine says of them.
#![allow(missing_docs)]

use diagnosis::{ActuatorModel, ChannelAnswer, Declared, Model, Recording, Verdict, diagnose};
use plant::Effect;
use rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::cell::Cell;
use std::f64::consts::TAU;

const H: f64 = 2e-3;

/// A command of several tones up to 4 Hz, at full size from its first sample on, mm.
fn command(seed: u64, size_mm: f64) -> impl Fn(f64) -> f64 {
    let tones = [0.31, 0.83, 1.7, 2.9, 4.1];
    move |t| {
        let tone = |(i, hz): (usize, &f64)| {
            let phase = (seed as f64 * 1.3 + i as f64 * 2.1).sin() * TAU;
            (TAU * hz * t + phase).sin() / (1.0 + i as f64)
        };
        size_mm * tones.iter().enumerate().map(tone).sum::<f64>()
    }
}

/// A record of 20 s of an actuator `x' = speed(e, x)`, by Runge and Kutta's method with ten steps a sample; `reads` is
/// what the transducer sees of the motion.
fn record(
    seed: u64,
    size_mm: f64,
    speed: impl Fn(f64, f64) -> f64,
    mut reads: impl FnMut(f64) -> f64,
) -> Recording {
    let u = command(seed, size_mm);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let delay_s = 0.006;
    // It is in motion long before the record begins.
    let (mut x, dt) = (0.0, H / 10.0);
    let mut r = Recording {
        name: format!("record {seed}"),
        ..Recording::default()
    };
    let (mut command_mm, mut displacement_mm) = (Vec::new(), Vec::new());
    for i in -2500..10_000_i32 {
        for k in 0..10 {
            let t = (f64::from(i) + f64::from(k) / 10.0) * H - delay_s;
            let f = |s: f64, x: f64| speed(u(t + s) - x, x);
            let (a, b) = (f(0.0, x), f(0.5 * dt, x + 0.5 * dt * f(0.0, x)));
            let c = f(0.5 * dt, x + 0.5 * dt * b);
            let d = f(dt, x + dt * c);
            x += dt / 6.0 * (a + 2.0 * b + 2.0 * c + d);
        }
        let noise: f64 = StandardNormal.sample(&mut random);
        let reading = reads(x) + 5e-4 * size_mm * noise;
        if i >= 0 {
            r.time_s.push(f64::from(i + 1) * H);
            command_mm.push(u(f64::from(i + 1) * H));
            displacement_mm.push(reading);
        }
    }
    r.command_mm = Some(command_mm);
    r.displacement_mm = Some(displacement_mm);
    r
}

fn model() -> Model {
    let declared = |value, tolerance| Some(Declared { value, tolerance });
    Model {
        actuator: Some(ActuatorModel {
            gain: declared(1.0, 0.01),
            delay_ms: declared(6.0, 1.0),
            lag_ms: declared(20.0, 1.0),
            offset_mm: declared(0.0, 0.1),
            effects: Vec::new(),
            remainder: None,
        }),
        specimen: None,
        ..Model::default()
    }
}

fn asked(make: impl Fn(u64) -> Recording) -> (ChannelAnswer, Model) {
    let d = diagnose(&model(), &[make(1)], &[make(2)], &[]).unwrap();
    let a = d.channels[0].clone();
    println!(
        "{:?} {:?} or {:?}: {:.4} -> {:.4} of {:.4} mm; {:?}",
        a.verdict,
        a.effects,
        a.alternatives,
        a.error_before.test_rms,
        a.error_after.test_rms,
        a.noise_floor_rms,
        a.notes
    );
    (a, d.improved)
}

/// A first-order valve.
fn plain(e: f64, _: f64) -> f64 {
    e / 0.02
}

fn named(a: &ChannelAnswer) -> Vec<Effect> {
    let found = a.effects.iter().map(|e| e.name);
    found.chain(a.alternatives.iter().copied()).collect()
}

#[test]
fn nothing_is_missing_in_a_plain_actuator_that_begins_in_mid_motion_without_a_rest() {
    let (a, _) = asked(|seed| record(seed, 10.0, plain, |x| x));
    assert_eq!(a.verdict, Verdict::None);
    assert!(
        (a.noise_floor_rms / 5e-3 - 1.0).abs() < 0.3,
        "{}",
        a.noise_floor_rms
    );
}

#[test]
fn unequal_areas_of_a_servo_cylinder_are_named_and_stay_in_the_model() {
    // Flow through an orifice out and back: proportional to the opening, by different areas.
    let valve = |e: f64, _: f64| if e > 0.0 { e / 0.018 } else { e / 0.022 };
    let make = |seed| record(seed, 10.0, valve, |x| x);
    let (a, improved) = asked(make);
    assert!(named(&a).contains(&Effect::AsymmetricActuator));
    assert!(a.error_after.test_rms < 0.6 * a.error_before.test_rms);
    // What was saved answers as what was found.
    let again = diagnose(&improved, &[make(1)], &[make(2)], &[]).unwrap();
    let left = again.channels[0].error_before.test_rms;
    assert!(left < 1.5 * a.error_after.test_rms, "{left}");
}

/// A ram whose specimen takes a quarter of its pressure at 20 mm; its piston goes so much faster one way than the other.
fn loaded(seed: u64, faster: f64) -> Recording {
    let valve = move |e: f64, x: f64| {
        let pressure = 1.0 - 0.0125 * x * e.signum();
        (1.0 + faster * e.signum()) * e * pressure.sqrt() / 0.02
    };
    record(seed, 10.0, valve, |x| x)
}

#[test]
fn a_specimen_behind_a_ram_is_no_finding_and_hides_none() {
    let (sound, _) = asked(|seed| loaded(seed, 0.0));
    assert_eq!(sound.verdict, Verdict::None, "{:?}", sound.notes);
    assert!(sound.ordinary);
    let (a, _) = asked(|seed| loaded(seed, 0.06));
    assert_eq!(named(&a), [Effect::AsymmetricActuator], "{:?}", a.notes);
}

#[test]
fn slack_in_a_linkage_is_a_play_or_friction_in_the_drive() {
    let make = |seed| {
        let mut at = 0.0_f64;
        record(seed, 10.0, plain, move |x| {
            at = at.clamp(x - 0.4, x + 0.4);
            at
        })
    };
    let (a, _) = asked(make);
    let names = named(&a);
    assert!(names.contains(&Effect::Backlash), "{names:?}");
    assert!(
        names.iter().all(|n| [
            Effect::Backlash,
            Effect::CoulombFriction,
            Effect::StribeckFriction
        ]
        .contains(n)),
        "{names:?}"
    );
    assert!(a.error_after.test_rms < 3.0 * a.noise_floor_rms);
}

/// Bristles (LuGre) of a give of 0.03 mm bend the oil by 0.4 mm; the position loop is around them, and a play behind it.
fn sealed(seed: u64, play_mm: f64) -> Recording {
    let u = command(seed, 10.0);
    let (mut oil, mut x, mut bristle, mut time) = (0.0, 0.0, 0.0_f64, -5.0);
    let dt = H / 10.0;
    // The ram's own equations in place of the record's; its clock runs beside that of the record.
    let mut r = record(seed, 10.0, |_, _| 0.0, |_| 0.0);
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed + 100);
    let (mut read, mut at) = (Vec::new(), 0.0_f64);
    while read.len() < r.time_s.len() {
        for _ in 0..10 {
            time += dt;
            oil += dt * (u(time - 0.006) - x) / 0.02;
            // Bisection for the place where the bristles hold the spring of the oil.
            let held = |at: f64| {
                let way = (at - x) / 0.03;
                (bristle + way) / (1.0 + way.abs())
            };
            let (mut low, mut high) = (x - 2.0, x + 2.0);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if middle + 0.4 * held(middle) < oil {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            bristle = held(low);
            x = low;
            at = at.clamp(x - 0.5 * play_mm, x + 0.5 * play_mm);
        }
        if time > 0.5 * dt {
            let noise: f64 = StandardNormal.sample(&mut random);
            read.push(at + 5e-3 * noise);
        }
    }
    r.displacement_mm = Some(read);
    r
}

#[test]
fn play_behind_a_loop_with_friction_in_it_is_named_beside_the_friction() {
    let (a, _) = asked(|seed| sealed(seed, 0.3));
    let mut names = named(&a);
    names.sort();
    assert_eq!(names, [Effect::CoulombFriction, Effect::Backlash], "{a:?}");
    let value = |name| {
        let effect = a.effects.iter().find(|e| e.name == name).unwrap();
        effect.parameters[0].value
    };
    let (bend, play) = (value(Effect::CoulombFriction), value(Effect::Backlash));
    assert!((bend / 0.4 - 1.0).abs() < 0.1, "{bend}");
    assert!((play / 0.3 - 1.0).abs() < 0.1, "{play}");
}

#[test]
fn seals_that_hold_the_piston_against_the_oil_are_friction() {
    let make = |seed| sealed(seed, 0.0);
    let (a, improved) = asked(make);
    assert!(
        matches!(a.verdict, Verdict::Effect | Verdict::Partial),
        "{a:?}"
    );
    assert_eq!(named(&a), [Effect::CoulombFriction]);
    let bend = a.effects[0].parameters[0].value;
    assert!((bend / 0.4 - 1.0).abs() < 0.15, "{bend}");
    assert!(a.error_after.test_rms < 0.3 * a.error_before.test_rms);
    let again = diagnose(&improved, &[make(1)], &[make(2)], &[]).unwrap();
    // A saved model begins at rest, this record in mid-motion: until the first reversal it does not know the friction's side.
    let left = again.channels[0].error_before.test_rms;
    println!("the saved model leaves {left:.4} mm");
    assert!(left < 0.4 * a.error_before.test_rms, "{left}");
}

#[test]
fn a_pump_that_is_too_small_limits_the_speed() {
    let make = |seed| record(seed, 10.0, |e, _| (e / 0.02).clamp(-120.0, 120.0), |x| x);
    let (a, _) = asked(make);
    assert!(named(&a).contains(&Effect::RateLimit), "{:?}", named(&a));
    assert!(a.error_after.test_rms < 0.2 * a.error_before.test_rms);
}

#[test]
fn a_supply_that_sags_is_no_sound_ram_and_has_no_name() {
    // What the piston has moved lately takes of its speed, in proportion: another law than the root of a pressure.
    let make = |seed| {
        let (drawn, before) = (Cell::new(0.0), Cell::new(0.0));
        let valve = |e: f64, _: f64| e / 0.02 * (1.0 - 1e-3 * drawn.get());
        let reads = |x: f64| {
            let speed = (x - before.replace(x)).abs() / H;
            drawn.set(drawn.get() + H / 0.3 * (speed - drawn.get()));
            x
        };
        record(seed, 10.0, valve, reads)
    };
    let (a, _) = asked(make);
    assert_eq!(a.verdict, Verdict::Unknown, "{a:?}");
    assert!(a.unnamed.is_some_and(|p| p > 0.72), "{:?}", a.unnamed);
    assert!(
        a.notes.iter().any(|n| n.contains("supply")),
        "{:?}",
        a.notes
    );
}

/// A second axis shakes the transducer at these frequencies: no input tells it.
fn shaken(seed: u64, hz: &'static [f64]) -> Recording {
    let mut i = 0.0;
    record(seed, 10.0, plain, move |x| {
        i += H;
        let each = hz.iter().map(|hz| (TAU * hz * i + seed as f64 * hz).sin());
        x + 0.3 * each.sum::<f64>()
    })
}

#[test]
fn lines_that_the_motion_does_not_have_are_beyond_tests() {
    let (a, _) = asked(|seed| shaken(seed, &[31.7, 37.9]));
    assert_eq!(a.verdict, Verdict::Unknown, "{a:?}");
    // No motion of this rig tells more of it.
    assert!(a.is_beyond_tests() && !a.is_open(), "{a:?}");
}

#[test]
fn another_motion_that_is_not_recorded_gets_no_name() {
    let (a, mut improved) = asked(|seed| shaken(seed, &[1.13, 2.31, 3.77, 5.9]));
    assert_eq!(a.verdict, Verdict::Unknown);
    // What comes nearest is there to be tried, switched off.
    let effects = &mut improved.actuator.as_mut().unwrap().effects;
    effects.retain(|e| e.enabled);
    assert_eq!(improved, model());
}

/// A parameter of the first name.
fn figure(a: &ChannelAnswer, name: &str) -> f64 {
    let mut all = a.effects[0].parameters.iter();
    all.find(|p| p.name == name).unwrap().value
}

/// What is found, by one name and to the noise, and what the saved model leaves.
fn found_and_saved(name: Effect, reads: impl Fn(f64) -> f64 + Copy) -> ChannelAnswer {
    let make = |seed| record(seed, 10.0, plain, reads);
    let (a, improved) = asked(make);
    assert_eq!(named(&a), [name], "{:?}", a.notes);
    assert!(a.error_after.test_rms < 1.2 * a.noise_floor_rms);
    let again = diagnose(&improved, &[make(1)], &[make(2)], &[]).unwrap();
    let left = again.channels[0].error_before.test_rms;
    assert!(left < 1.1 * a.error_after.test_rms, "{left}");
    a
}

#[test]
fn a_dead_band_whose_middle_is_not_zero_is_found_to_the_noise_and_saved() {
    let a = found_and_saved(Effect::DeadBand, |x: f64| {
        let from = x - 0.3;
        0.3 + from - from.clamp(-0.5, 0.5)
    });
    let width = figure(&a, "width_mm");
    assert!((width - 1.0).abs() < 0.02, "{width}");
}

/// Rubber in front of the stops.
#[test]
fn a_limit_with_rounded_corners_is_a_limit_and_is_found_to_the_noise() {
    let soft = |over: f64| 0.15 * (1.0 + (over / 0.15).exp()).ln();
    let a = found_and_saved(Effect::Saturation, |x: f64| {
        x - soft(x - 7.0) + soft(-8.0 - x)
    });
    let limit = figure(&a, "limit_mm");
    assert!((limit - 7.0).abs() < 0.1, "{limit}");
}
