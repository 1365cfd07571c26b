//! A law that needs another spring than the declared one is not all that is missing, unless it may be part of that spring; an
//! empty gap and friction that falls by half have their own names.

use super::spring::STIFFNESS_N_PER_MM;
use super::{asked, between_rests, friction, is_held_possible, said, shaken, speed};
use diagnosis::{ChannelAnswer, Verdict};
use plant::Effect;

fn moved() -> Vec<f64> {
    shaken(24.0, |u| between_rests(u, 0.05))
}

/// The answer for a specimen of this force along a motion.
fn of(x: &[f64], force: impl Fn(f64) -> f64) -> ChannelAnswer {
    let more: Vec<f64> = x
        .iter()
        .map(|x| force(*x) - STIFFNESS_N_PER_MM * x)
        .collect();
    asked(x, &more)
}

fn names(a: &ChannelAnswer) -> Vec<Effect> {
    a.effects.iter().map(|e| e.name).collect()
}

fn error_of_gain(a: &ChannelAnswer) -> Option<f64> {
    let gain = a.effects.iter().find(|e| e.name == Effect::GainError)?;
    Some(gain.parameters[0].value)
}

#[test]
fn sides_that_are_both_softer_than_declared_are_unequal_and_behind_a_scale_or_a_frame() {
    let x = moved();
    let a = of(&x, |x| 700.0 * x + 60.0 * x.abs());
    assert_eq!(a.verdict, Verdict::Ambiguous, "{}", said(&a));
    for name in [
        Effect::AsymmetricStiffness,
        Effect::GainError,
        Effect::RigCompliance,
    ] {
        assert!(is_held_possible(&a, name), "{}", said(&a));
    }
    // One side is as declared.
    let a = of(&x, |x| 880.0 * x + 120.0 * x.abs());
    assert_eq!(names(&a), [Effect::AsymmetricStiffness], "{}", said(&a));
}

#[test]
fn a_spring_is_as_declared_beside_friction_or_named() {
    let x = moved();
    let slides = friction(&x, 400.0);
    let with = |share: f64| {
        let more = x.iter().zip(&slides);
        let more: Vec<f64> = more
            .map(|(x, f)| share * STIFFNESS_N_PER_MM * x + f)
            .collect();
        asked(&x, &more)
    };
    let a = with(0.0);
    assert_eq!(names(&a), [Effect::CoulombFriction], "{}", said(&a));
    for share in [0.12, -0.12] {
        let a = with(share);
        assert!(names(&a).contains(&Effect::CoulombFriction), "{}", said(&a));
        assert!(
            is_held_possible(&a, Effect::GainError),
            "{share}: {}",
            said(&a)
        );
        assert_eq!(
            is_held_possible(&a, Effect::RigCompliance),
            share < 0.0,
            "{share}: {}",
            said(&a)
        );
    }
}

/// Elastic until it yields at 600 N.
fn yields(x: &[f64], n_per_mm: f64) -> Vec<f64> {
    let (mut f, mut last) = (0.0_f64, x[0]);
    let force = |x: &f64| {
        f = (f + n_per_mm * (x - last)).clamp(-600.0, 600.0);
        last = *x;
        f
    };
    x.iter().map(force).collect()
}

#[test]
fn a_yielding_device_may_have_a_spring_of_its_own_and_may_be_part_of_the_declared_one() {
    let x = moved();
    for own in [300.0, -150.0] {
        let device = yields(&x, 200.0).into_iter().zip(&x);
        let more: Vec<f64> = device.map(|(f, x)| f + own * x).collect();
        let a = asked(&x, &more);
        assert!(
            is_held_possible(&a, Effect::BilinearHysteresis),
            "{own}: {}",
            said(&a)
        );
        assert!(
            !is_held_possible(&a, Effect::GainError),
            "{own}: {}",
            said(&a)
        );
    }
    // Neither before nor after it yields: its error is that before.
    let device = yields(&x, 200.0).into_iter().zip(&x);
    let more: Vec<f64> = device.map(|(f, x)| f - 450.0 * x).collect();
    let a = asked(&x, &more);
    assert!(is_held_possible(&a, Effect::GainError), "{}", said(&a));
    let error = error_of_gain(&a);
    assert!(
        error.is_some_and(|e| (e + 0.25).abs() < 0.03),
        "{error:?} {}",
        said(&a)
    );
}

#[test]
fn a_gap_with_hardly_a_spring_in_it_is_one() {
    let x = moved();
    let beyond = |x: f64| x - x.clamp(-2.0, 2.0);
    let a = of(&x, |x| STIFFNESS_N_PER_MM * (0.02 * x + 0.98 * beyond(x)));
    assert_eq!(names(&a), [Effect::DeadBand], "{}", said(&a));
    let a = of(&x, |x| STIFFNESS_N_PER_MM * (0.5 * x + 0.5 * beyond(x)));
    assert!(!is_held_possible(&a, Effect::DeadBand), "{}", said(&a));
    assert!(is_held_possible(&a, Effect::Hardening), "{}", said(&a));
    // The error of a spring that is stiffer than declared is that of the spring in contact.
    let a = of(&x, |x| 1200.0 * (0.02 * x + 0.98 * beyond(x)));
    assert!(is_held_possible(&a, Effect::DeadBand), "{}", said(&a));
    let error = error_of_gain(&a);
    assert!(
        error.is_some_and(|e| (e - 0.2).abs() < 0.02),
        "{error:?} {}",
        said(&a)
    );
    // Stops beside a spring that is softer than declared: they bear, but its error is its own.
    let stops = |x: f64| x - x.clamp(-7.0, 7.0);
    let a = of(&x, |x| 850.0 * x + 3000.0 * stops(x));
    let error = error_of_gain(&a);
    let is_own = |e: f64| (e + 0.15).abs() < 0.02;
    assert!(error.is_some_and(is_own), "{error:?} {}", said(&a));
    assert!(is_held_possible(&a, Effect::GainError), "{}", said(&a));
}

#[test]
fn friction_that_falls_by_half_is_no_other_friction() {
    let x = moved();
    let slow = |i: usize| (-(speed(&x, i) / 12.0).abs().powf(1.5)).exp();
    let slides = yields(&x, 6000.0).into_iter().enumerate();
    let falls: Vec<f64> = slides.map(|(i, f)| f * (1.0 + 0.9 * slow(i))).collect();
    let a = asked(&x, &falls);
    assert_eq!(names(&a), [Effect::StribeckFriction], "{}", said(&a));
    assert!(
        !is_held_possible(&a, Effect::CoulombFriction),
        "{}",
        said(&a)
    );
}
