//! Declared parameters after a diagnosis: reported with intervals, saved, and never past what was declared; what comes nearest is
//! saved switched off.
#![allow(missing_docs)]

#[allow(dead_code, reason = "each file of tests uses a part of it")]
mod rig;

use diagnosis::{Diagnosis, Recording, Verdict, diagnose};
use plant::Effect;
use rig::{model, record};

/// A rig whose lag is 24.4 ms where 22 +- 1 are declared.
fn slow() -> [Recording; 2] {
    [5, 6].map(|seed| record(&[], [1000.0, 5.0, 24.4], seed))
}

fn lag_ms(d: &Diagnosis) -> diagnosis::Declared {
    d.improved.actuator.as_ref().unwrap().lag_ms.unwrap()
}

#[test]
fn a_refit_is_saved_where_nothing_is_added_and_does_not_walk() {
    let [train, test] = slow().map(|r| [r]);
    let d = diagnose(&model(), &train, &test, &[]).unwrap();
    let actuator = &d.channels[0];
    assert_eq!(actuator.verdict, Verdict::None, "{:?}", actuator.notes);
    // What it leaves is noise, and no oil and valve.
    assert!(!actuator.ordinary, "{:?}", actuator.notes);
    let own = actuator
        .refitted
        .iter()
        .find(|r| r.name == "lag_ms")
        .unwrap();
    assert!((own.value - 24.4).abs() < 0.3, "{own:?}");
    assert!(own.ci90[0] < own.value && own.value < own.ci90[1] && own.ci90[1] - own.ci90[0] < 2.0);
    // What the model leaves as it was declared, and refitted.
    let [declared, refitted] = [actuator.error_declared, actuator.error_before].map(|e| e.test_rms);
    assert!(declared > 2.0 * refitted, "{declared} {refitted}");
    let saved = lag_ms(&d);
    assert_eq!(saved.value, own.value);
    // It may still go as far as was declared, and no further.
    assert!(saved.value + 3.0 * saved.tolerance < 25.4, "{saved:?}");
    let again = diagnose(&d.improved, &train, &test, &[]).unwrap();
    assert!(
        (lag_ms(&again).value - saved.value).abs() < 0.05,
        "{:?}",
        lag_ms(&again)
    );
    assert!(lag_ms(&again).tolerance <= saved.tolerance);
}

#[test]
fn a_lag_far_outside_its_tolerance_is_the_cause_and_nothing_else_gets_the_credit() {
    // 25 tolerances.
    let [train, test] = [7, 8].map(|seed| [record(&[], [1000.0, 5.0, 47.0], seed)]);
    let d = diagnose(&model(), &train, &test, &[]).unwrap();
    let a = &d.channels[0];
    let names: Vec<Effect> = a.effects.iter().map(|e| e.name).collect();
    assert_eq!(names, [Effect::LagError], "{:?} {:?}", a.verdict, a.notes);
    assert!(
        (lag_ms(&d).value - 47.0).abs() < 1.0,
        "{:?}",
        d.improved.actuator
    );
    assert!(a.error_after.test_rms < 1.5 * a.noise_floor_rms);
}

/// Nothing is recorded any more after so many seconds.
fn cut_off(r: &mut Recording, seconds: f64) {
    let n = r.time_s.partition_point(|t| *t < seconds);
    r.time_s.truncate(n);
    for signal in [&mut r.command_mm, &mut r.displacement_mm, &mut r.force_n] {
        signal.as_mut().unwrap().truncate(n);
    }
}

/// On a record that took no part in it, whatever the declared numbers are, and however little of the motion there is to learn from.
#[test]
fn a_refit_is_never_worse_than_what_was_declared() {
    let mut better = 0;
    for seed in 40..52_u64 {
        let off = |k: u64| (seed * (2 * k + 7) % 11) as f64 / 5.0 - 1.0;
        let truth = [
            1000.0 + 9.0 * off(0),
            5.0 + 0.45 * off(1),
            22.0 + 0.9 * off(2),
        ];
        let [mut train, test] = [2 * seed, 2 * seed + 1].map(|s| [record(&[], truth, s)]);
        if seed % 2 == 0 {
            // With two seconds of rest in front.
            cut_off(&mut train[0], 4.0 + (seed % 5) as f64);
        }
        let d = diagnose(&model(), &train, &test, &[]).unwrap();
        for a in &d.channels {
            let [declared, refitted] = [a.error_declared, a.error_before].map(|e| e.test_rms);
            println!("{seed} {:?}: {declared:.5} -> {refitted:.5}", a.channel);
            assert!(
                refitted <= 1.002 * declared,
                "{seed}: {declared} {refitted}"
            );
            better += usize::from(refitted < 0.99 * declared);
        }
    }
    assert!(better > 8, "{better} of 24 are better");
}

/// Another axis moves the piston, too: it follows no command of this one.
fn pushed(mut r: Recording, seed: u32) -> Recording {
    let x = r.displacement_mm.as_mut().unwrap();
    for (x, t) in x.iter_mut().zip(&r.time_s) {
        let sine = |k: u32| {
            let hz = 0.37 * f64::from(k) + 0.01 * f64::from(seed % 7);
            (std::f64::consts::TAU * hz * t + f64::from(k * k * seed)).sin()
        };
        let moves = (4.0..18.0).contains(t);
        *x += f64::from(u8::from(moves)) * PUSHED_MM * (1..17).map(sine).sum::<f64>();
    }
    r
}

/// One of 16 sines.
const PUSHED_MM: f64 = 0.05;

#[test]
fn a_lag_outside_its_tolerance_is_named_beside_more_that_has_no_name() {
    // Ten tolerances; three of them the refit takes.
    let of = |seed: u32| [pushed(record(&[], [1000.0, 5.0, 32.0], seed.into()), seed)];
    let [train, test] = [7, 8].map(of);
    let mut declared = model();
    declared.specimen = None;
    let d = diagnose(&declared, &train, &test, &[]).unwrap();
    let a = &d.channels[0];
    let names: Vec<Effect> = a.effects.iter().map(|e| e.name).collect();
    assert_eq!(names, [Effect::LagError], "{:?} {:?}", a.verdict, a.notes);
    assert_eq!(a.verdict, Verdict::Partial);
    // Beside the refit it explains too little by itself.
    let share = a.error_after.test_rms / a.error_before.test_rms;
    assert!(share > 0.7, "{share}");
}

/// A spring with a force that no effect of the library has.
fn odd(name: &str, hz: f64) -> Recording {
    let time_s: Vec<f64> = (0..12_000).map(|i| f64::from(i) * 1e-3).collect();
    let moves = |t: f64| (std::f64::consts::TAU * hz * (t - 2.0).max(0.0)).sin() * 5.0;
    let x: Vec<f64> = time_s.iter().map(|t| moves(*t)).collect();
    let noise = |i: usize| 0.5 * (((i * 7919) % 1009) as f64 / 504.5 - 1.0);
    let force = |(i, t): (usize, &f64)| {
        let (x, v) = (moves(*t), (moves(t + 1e-4) - moves(t - 1e-4)) / 2e-4);
        1000.0 * x + 80.0 * (3.0 * x).sin() * (1.0 + 0.02 * v) + noise(i)
    };
    Recording {
        name: name.into(),
        force_n: Some(time_s.iter().enumerate().map(force).collect()),
        displacement_mm: Some(x),
        time_s,
        ..Recording::default()
    }
}

#[test]
fn what_comes_nearest_is_saved_switched_off_and_changes_nothing() {
    let mut declared = model();
    declared.actuator = None;
    let (train, test) = ([odd("a", 0.9)], [odd("b", 1.3)]);
    let d = diagnose(&declared, &train, &test, &[]).unwrap();
    let a = &d.channels[0];
    assert_eq!(a.verdict, Verdict::Unknown, "{:?}", a.notes);
    let nearest = a.nearest.as_ref().unwrap().name;
    let saved = d.improved.specimen.as_ref().unwrap();
    let effects = saved.effects.iter().map(|e| (e.name, e.enabled));
    let elements = saved.elements.iter().map(|e| (e.name, e.enabled));
    let off: Vec<_> = effects.chain(elements).collect();
    assert_eq!(off, [(nearest, false)]);
    let again = diagnose(&d.improved, &train, &test, &[]).unwrap();
    let [first, second] = [&d, &again].map(|d| d.channels[0].error_before.test_rms);
    assert!((first - second).abs() < 0.01 * first, "{first} {second}");
    // Switched on it is a part of the model.
    let mut on = d.improved.clone();
    let own = on.specimen.as_mut().unwrap();
    own.effects.iter_mut().for_each(|e| e.enabled = true);
    own.elements.iter_mut().for_each(|e| e.enabled = true);
    let on = diagnose(&on, &train, &test, &[]).unwrap();
    let explained = a.nearest.as_ref().unwrap().explained;
    // Else what is switched on could do nothing unseen.
    assert!(explained > 0.2, "{explained}");
    let left = on.channels[0].error_before.test_rms / a.error_before.test_rms;
    assert!(
        (left - (1.0 - explained).sqrt()).abs() < 0.05,
        "{left} {explained}"
    );
}

#[test]
fn each_name_has_a_probability() {
    let friction = plant::EffectSpec::new(
        plant::Effect::CoulombFriction,
        &[("force_n", 300.0), ("presliding_mm", 0.05)],
    );
    let [train, test] = [11, 12].map(|seed| {
        [record(
            std::slice::from_ref(&friction),
            [1000.0, 5.0, 22.0],
            seed,
        )]
    });
    let d = diagnose(&model(), &train, &test, &[]).unwrap();
    let a = &d.channels[1];
    assert!(!a.effects.is_empty(), "{:?}", a.notes);
    assert!(
        a.effects
            .iter()
            .all(|e| e.p.is_some_and(|p| (0.0..=1.0).contains(&p)))
    );
    // Of a specimen free functions have no name, of an actuator a supply that sags: this one has none.
    assert!(a.unnamed.is_some_and(|p| (0.0..=1.0).contains(&p)));
    assert!(
        d.channels[0].unnamed.is_some_and(|p| p < 0.2),
        "{:?}",
        d.channels[0].unnamed
    );
}
